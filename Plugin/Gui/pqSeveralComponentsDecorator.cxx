// SPDX-License-Identifier: BSD-3-Clause
#include "pqSeveralComponentsDecorator.h"

#include "pqCoreUtilities.h"
#include "pqPropertyWidget.h"
#include "vtkCommand.h"
#include "vtkSMEnumerationDomain.h"
#include "vtkSMProperty.h"

pqSeveralComponentsDecorator::pqSeveralComponentsDecorator(
  vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  pqCoreUtilities::connect(
    parent->property(), vtkCommand::DomainModifiedEvent, this, SIGNAL(visibilityChanged()));
}

bool pqSeveralComponentsDecorator::canShowWidget(bool showAdvanced) const
{
  auto* components = this->parentWidget()->property()->FindDomain<vtkSMEnumerationDomain>();
  return (!components || components->GetNumberOfEntries() > 1) &&
    this->Superclass::canShowWidget(showAdvanced);
}
