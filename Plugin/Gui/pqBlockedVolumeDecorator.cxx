// SPDX-License-Identifier: BSD-3-Clause
#include "pqBlockedVolumeDecorator.h"

#include "pqIndexStatus.h"

#include "pqCoreUtilities.h"
#include "pqPropertyWidget.h"
#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <cstring>

namespace
{

vtkSMProxy* FindProducer(vtkSMProxy* filter)
{
  vtkSMProperty* input = filter->GetProperty("Input");
  return input ? vtkSMPropertyHelper(input).GetAsProxy() : nullptr;
}

} // namespace

pqBlockedVolumeDecorator::pqBlockedVolumeDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  if (vtkSMProperty* input = parent->proxy()->GetProperty("Input"))
  {
    pqCoreUtilities::connect(input, vtkCommand::ModifiedEvent, this, SIGNAL(visibilityChanged()));
  }
}

bool pqBlockedVolumeDecorator::canShowWidget(bool showAdvanced) const
{
  return IsBehindReader(this->parentWidget()->proxy()) &&
    this->Superclass::canShowWidget(showAdvanced);
}

bool pqBlockedVolumeDecorator::IsReader(vtkSMProxy* proxy)
{
  return std::strcmp(proxy->GetXMLName(), "BlockedVolumeReader") == 0 ||
    pqIndexStatus::IsReader(proxy);
}

bool pqBlockedVolumeDecorator::IsBehindReader(vtkSMProxy* filter)
{
  vtkSMProxy* producer = FindProducer(filter);
  while (producer && std::strcmp(producer->GetXMLName(), "PassArrays") == 0)
  {
    producer = FindProducer(producer);
  }
  return producer && IsReader(producer);
}
