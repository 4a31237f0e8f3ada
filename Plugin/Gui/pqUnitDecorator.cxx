// SPDX-License-Identifier: BSD-3-Clause
#include "pqUnitDecorator.h"

#include "pqPropertyWidget.h"
#include "vtkPVXMLElement.h"

#include <QBoxLayout>
#include <QLabel>

pqUnitDecorator::pqUnitDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  if (auto* row = qobject_cast<QBoxLayout*>(parent->layout()))
  {
    auto* unit = new QLabel(xml->GetAttribute("text"), parent);
    unit->setObjectName("Unit");
    row->addWidget(unit);
  }
}
