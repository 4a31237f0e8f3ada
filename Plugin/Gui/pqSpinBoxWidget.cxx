// SPDX-License-Identifier: BSD-3-Clause
#include "pqSpinBoxWidget.h"

#include "vtkSMIntRangeDomain.h"
#include "vtkSMProperty.h"

#include <QDoubleSpinBox>
#include <QHBoxLayout>

namespace
{
/// Whole numbers up to here are exact as doubles.
constexpr double LargestNumber = 9007199254740992.0;
} // namespace

pqSpinBoxWidget::pqSpinBoxWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
{
  auto* box = new QDoubleSpinBox(this); // of 64-bit numbers, too
  box->setDecimals(0);
  box->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  box->setObjectName("SpinBox");
  box->setFocusPolicy(Qt::StrongFocus); // the wheel scrolls the panel
  auto* range = property->FindDomain<vtkSMIntRangeDomain>();
  const bool hasMaximum = range && range->GetMaximumExists(0);
  box->setMinimum(range && range->GetMinimumExists(0) ? range->GetMinimum(0) : 0);
  box->setMaximum(hasMaximum ? range->GetMaximum(0) : LargestNumber);
  box->setMinimumWidth(60); // the largest number would make the panel scroll sideways
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(box, 1);
  this->addPropertyLink(box, "value", SIGNAL(valueChanged(double)), property);
  QObject::connect(box, SIGNAL(editingFinished()), this, SIGNAL(changeFinished()));
  this->setChangeAvailableAsChangeFinished(false);
}
