// SPDX-License-Identifier: BSD-3-Clause
#include "pqInformationLine.h"

#include "pqCoreUtilities.h"
#include "vtkCommand.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include "pqPropertyWidgetDecorator.h"

#include <QHBoxLayout>
#include <QLabel>

namespace
{

/// Hides a line that has nothing to tell.
class TextDecorator : public pqPropertyWidgetDecorator
{
public:
  explicit TextDecorator(pqInformationLine* line)
    : pqPropertyWidgetDecorator(nullptr, line)
    , Line(line)
  {
  }
  bool canShowWidget(bool showAdvanced) const override
  {
    return !this->Line->GetText().isEmpty() &&
      pqPropertyWidgetDecorator::canShowWidget(showAdvanced);
  }

private:
  const pqInformationLine* Line;
};

} // namespace

pqInformationLine::pqInformationLine(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
  , Label(new QLabel(this))
{
  this->setProperty(property);
  this->setShowLabel(true);
  this->Label->setObjectName("Text");
  this->Label->setWordWrap(true);
  this->Label->setSizePolicy(
    QSizePolicy::Ignored, QSizePolicy::Preferred); // no wider than the panel
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(this->Label);
  pqCoreUtilities::connect(proxy, vtkCommand::UpdateDataEvent, this, SLOT(Read()));
  this->Decorator = new TextDecorator(this);
  this->Read();
}

QString pqInformationLine::GetText() const
{
  return this->Text;
}

void pqInformationLine::Read()
{
  // Others may take long: the list of a folder's datasets, say.
  this->proxy()->UpdatePropertyInformation(this->Superclass::property());
  const char* text = vtkSMPropertyHelper(this->Superclass::property()).GetAsString();
  const bool wasEmpty = this->Text.isEmpty();
  this->Text = text ? text : "";
  // Paths have no blanks to break a line at.
  this->Label->setText(QString(this->Text).replace("/", "/" + QString(QChar(0x200B))));
  if (this->Text.isEmpty() != wasEmpty)
  {
    Q_EMIT this->Decorator->visibilityChanged();
  }
}
