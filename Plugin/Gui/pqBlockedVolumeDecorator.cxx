// SPDX-License-Identifier: BSD-3-Clause
#include "pqBlockedVolumeDecorator.h"

#include "pqCoreUtilities.h"
#include "pqPropertyWidget.h"
#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <cstring>

//------------------------------------------------------------------------------
pqBlockedVolumeDecorator::pqBlockedVolumeDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  if (vtkSMProperty* input = parent->proxy()->GetProperty("Input"))
  {
    pqCoreUtilities::connect(input, vtkCommand::ModifiedEvent, this, SIGNAL(visibilityChanged()));
  }
}

//------------------------------------------------------------------------------
pqBlockedVolumeDecorator::~pqBlockedVolumeDecorator() = default;

//------------------------------------------------------------------------------
bool pqBlockedVolumeDecorator::canShowWidget(bool showAdvanced) const
{
  return IsBehindReader(this->parentWidget()->proxy()) &&
    this->Superclass::canShowWidget(showAdvanced);
}

//------------------------------------------------------------------------------
bool pqBlockedVolumeDecorator::IsBehindReader(vtkSMProxy* filter)
{
  vtkSMProperty* input = filter->GetProperty("Input");
  vtkSMProxy* producer = input ? vtkSMPropertyHelper(input).GetAsProxy() : nullptr;
  return producer && std::strcmp(producer->GetXMLName(), "BlockedVolumeReader") == 0;
}
