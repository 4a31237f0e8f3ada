// SPDX-License-Identifier: BSD-3-Clause
#include "pqFoundValueWidget.h"

#include "pqCoreUtilities.h"
#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"
#include "vtkSMStringVectorProperty.h"

#include <QDoubleValidator>
#include <QHBoxLayout>
#include <QLineEdit>
#include <QLocale>
#include <QSignalBlocker>

#include <algorithm>
#include <string>

pqFoundValueWidget::pqFoundValueWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
{
  this->setProperty(property);
  const bool isText = vtkSMStringVectorProperty::SafeDownCast(property) != nullptr;
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  for (int number = 0; number < (isText ? 1 : 3); ++number)
  {
    auto* field = new QLineEdit(this);
    field->setObjectName("Field" + QString::number(number));
    field->setMinimumWidth(40); // three would make the panel scroll sideways
    QObject::connect(field, SIGNAL(editingFinished()), this, SIGNAL(changeFinished()));
    row->addWidget(field);
    this->Fields.push_back(field);
    if (!isText)
    {
      auto* validator = new QDoubleValidator(field);
      validator->setLocale(QLocale::c());
      field->setValidator(validator);
      QObject::connect(field, &QLineEdit::textChanged, this, &pqFoundValueWidget::FillOthers);
      QObject::connect(field, &QLineEdit::editingFinished, this, &pqFoundValueWidget::EmptyIfFound);
    }
  }
  this->setChangeAvailableAsChangeFinished(false);
  pqCoreUtilities::connect(proxy, vtkCommand::UpdateDataEvent, this, SLOT(ReadFound()));
  this->ReadFound();
  if (isText)
  {
    this->addPropertyLink(this->Fields[0], "text", SIGNAL(textChanged(QString)), property);
  }
  else
  {
    this->addPropertyLink(this, "numbers", SIGNAL(numbersChanged()), property);
  }
}

QVariantList pqFoundValueWidget::GetNumbers() const
{
  QVariantList numbers;
  if (std::any_of(this->Fields.begin(), this->Fields.end(),
        [](const QLineEdit* field) { return !field->text().isEmpty(); }))
  {
    for (const QLineEdit* field : this->Fields)
    {
      numbers.push_back(
        (field->text().isEmpty() ? field->placeholderText() : field->text()).toDouble());
    }
  }
  return numbers;
}

void pqFoundValueWidget::SetNumbers(const QVariantList& numbers)
{
  if (numbers == this->GetNumbers())
  {
    return; // a field that is being edited stays as it is
  }
  for (int number = 0; number < this->Fields.size(); ++number)
  {
    const QSignalBlocker blocker(this->Fields[number]);
    this->Fields[number]->setText(number < numbers.size()
        ? QString::number(numbers[number].toDouble(), 'g', QLocale::FloatingPointShortest)
        : "");
  }
}

void pqFoundValueWidget::FillOthers()
{
  const bool isSet = !this->GetNumbers().isEmpty();
  for (QLineEdit* field : this->Fields)
  {
    if (isSet && field->text().isEmpty() && field != this->sender())
    {
      const QSignalBlocker blocker(field);
      field->setText(field->placeholderText());
    }
  }
  Q_EMIT this->numbersChanged();
}

void pqFoundValueWidget::EmptyIfFound()
{
  if (std::all_of(this->Fields.begin(), this->Fields.end(),
        [](const QLineEdit* field)
        {
          return field->text().isEmpty() ||
            field->text().toDouble() == field->placeholderText().toDouble();
        }))
  {
    this->SetNumbers({});
    Q_EMIT this->numbersChanged();
  }
}

void pqFoundValueWidget::ReadFound()
{
  const std::string name = this->proxy()->GetPropertyName(this->Superclass::property());
  vtkSMProperty* const found = this->proxy()->GetProperty((name + "Info").c_str());
  this->proxy()->UpdatePropertyInformation(found);
  const vtkSMPropertyHelper values(found);
  for (int number = 0; number < this->Fields.size(); ++number)
  {
    this->Fields[number]->setPlaceholderText(vtkSMStringVectorProperty::SafeDownCast(found)
        ? QString(values.GetAsString())
        : QString::number(values.GetAsDouble(number), 'g', QLocale::FloatingPointShortest));
  }
}
