// SPDX-License-Identifier: BSD-3-Clause
#include "pqInformationLine.h"

#include "pqCoreUtilities.h"
#include "vtkCommand.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QHBoxLayout>
#include <QLabel>

//------------------------------------------------------------------------------
pqInformationLine::pqInformationLine(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
  , Label(new QLabel(this))
{
  this->setProperty(property);
  this->setShowLabel(true);
  this->Label->setObjectName("Text");
  this->Label->setWordWrap(true);
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(this->Label);
  pqCoreUtilities::connect(proxy, vtkCommand::UpdateDataEvent, this, SLOT(Read()));
  this->Read();
}

//------------------------------------------------------------------------------
pqInformationLine::~pqInformationLine() = default;

//------------------------------------------------------------------------------
QString pqInformationLine::GetText() const
{
  return this->Label->text();
}

//------------------------------------------------------------------------------
void pqInformationLine::Read()
{
  // Others may take long: the list of a folder's datasets, say.
  this->proxy()->UpdatePropertyInformation(this->Superclass::property());
  const char* text = vtkSMPropertyHelper(this->Superclass::property()).GetAsString();
  this->Label->setText(text ? text : "");
}
