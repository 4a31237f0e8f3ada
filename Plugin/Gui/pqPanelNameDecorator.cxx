// SPDX-License-Identifier: BSD-3-Clause
#include "pqPanelNameDecorator.h"

#include "pqPropertyWidget.h"
#include "vtkPVXMLElement.h"

#include <QCheckBox>
#include <QComboBox>
#include <QEvent>
#include <QGridLayout>
#include <QLabel>

pqPanelNameDecorator::pqPanelNameDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
  , Name(xml->GetAttribute("text"))
{
  if (auto* box = parent->findChild<QCheckBox*>())
  {
    box->setText(this->Name);
  }
  if (auto* box = parent->findChild<QComboBox*>())
  {
    // A long entry would make the panel scroll sideways.
    box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  }
  parent->installEventFilter(this); // it gets its place in the panel, and its label, later
}

bool pqPanelNameDecorator::eventFilter(QObject* object, QEvent* event)
{
  if (event->type() == QEvent::Show)
  {
    this->Rename();
  }
  return Superclass::eventFilter(object, event);
}

void pqPanelNameDecorator::Rename() const
{
  pqPropertyWidget* widget = this->parentWidget();
  const QWidget* panel = widget->parentWidget();
  const auto* grid = panel ? qobject_cast<QGridLayout*>(panel->layout()) : nullptr;
  const int index = grid ? grid->indexOf(widget) : -1;
  if (index < 0)
  {
    return;
  }
  int row = 0;
  int column = 0;
  int rows = 0;
  int columns = 0;
  grid->getItemPosition(index, &row, &column, &rows, &columns);
  QLayoutItem* item = column > 0 ? grid->itemAtPosition(row, 0) : nullptr;
  if (auto* label = item ? qobject_cast<QLabel*>(item->widget()) : nullptr)
  {
    label->setText(this->Name);
  }
}
