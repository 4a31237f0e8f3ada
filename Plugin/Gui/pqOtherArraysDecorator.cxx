// SPDX-License-Identifier: BSD-3-Clause
#include "pqOtherArraysDecorator.h"

#include "pqCoreUtilities.h"
#include "pqPropertyWidget.h"
#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <QAbstractItemModel>
#include <QTimer>
#include <QTreeView>

namespace
{
/// Of SelectInputScalars: three numbers, the association, the array's name.
constexpr int ArrayNameElement = 4;
} // namespace

pqOtherArraysDecorator::pqOtherArraysDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent)
  : Superclass(xml, parent)
{
  for (const char* name : { "SelectInputScalars", "ComputeScalars" })
  {
    if (vtkSMProperty* property = parent->proxy()->GetProperty(name))
    {
      pqCoreUtilities::connect(
        property, vtkCommand::UncheckedPropertyModifiedEvent, this, SLOT(ExpectChange()));
    }
  }
  pqCoreUtilities::connect(
    parent->property(), vtkCommand::DomainModifiedEvent, this, SLOT(ExpectChange()));
  this->ExpectChange();
}

bool pqOtherArraysDecorator::canShowWidget(bool showAdvanced) const
{
  return !this->IsEmpty && this->Superclass::canShowWidget(showAdvanced);
}

void pqOtherArraysDecorator::ExpectChange()
{
  // The list itself is filled by another observer of the same event.
  QTimer::singleShot(0, this, &pqOtherArraysDecorator::HideContoured);
}

void pqOtherArraysDecorator::HideContoured()
{
  vtkSMProxy* proxy = this->parentWidget()->proxy();
  vtkSMUncheckedPropertyHelper choice(proxy, "SelectInputScalars", true);
  const char* contoured = choice.GetNumberOfElements() > ArrayNameElement
    ? choice.GetAsString(ArrayNameElement)
    : nullptr;
  const bool taken = vtkSMUncheckedPropertyHelper(proxy, "ComputeScalars", true).GetAsInt() != 0;
  QString hiddenArray;
  bool isEmpty = true;
  for (QTreeView* list : this->parentWidget()->findChildren<QTreeView*>())
  {
    const QAbstractItemModel* model = list->model();
    for (int row = 0; model && row < model->rowCount(); ++row)
    {
      const QString name = model->index(row, 0).data().toString();
      const bool hidden = taken && name == contoured;
      list->setRowHidden(row, QModelIndex(), hidden);
      hiddenArray = hidden ? name : hiddenArray;
      isEmpty = isEmpty && hidden;
    }
  }
  this->parentWidget()->setProperty("hiddenArray", hiddenArray);
  this->IsEmpty = isEmpty;
  Q_EMIT this->visibilityChanged();
}
