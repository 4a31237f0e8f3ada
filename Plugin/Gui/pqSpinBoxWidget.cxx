// SPDX-License-Identifier: BSD-3-Clause
#include "pqSpinBoxWidget.h"

#include "pqSpinBox.h"
#include "vtkSMIntRangeDomain.h"
#include "vtkSMProperty.h"

#include <QHBoxLayout>

#include <limits>

//------------------------------------------------------------------------------
pqSpinBoxWidget::pqSpinBoxWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
{
  auto* box = new pqSpinBox(this);
  box->setObjectName("SpinBox");
  box->setFocusPolicy(Qt::StrongFocus); // the wheel scrolls the panel
  auto* range = property->FindDomain<vtkSMIntRangeDomain>();
  const bool hasMaximum = range && range->GetMaximumExists(0);
  box->setMinimum(range && range->GetMinimumExists(0) ? range->GetMinimum(0) : 0);
  box->setMaximum(hasMaximum ? range->GetMaximum(0) : std::numeric_limits<int>::max());
  auto* row = new QHBoxLayout(this);
  row->setMargin(0);
  row->addWidget(box, 1);
  this->addPropertyLink(box, "value", SIGNAL(valueChanged(int)), property);
  QObject::connect(box, SIGNAL(editingFinished()), this, SIGNAL(changeFinished()));
  this->setChangeAvailableAsChangeFinished(false);
}

//------------------------------------------------------------------------------
pqSpinBoxWidget::~pqSpinBoxWidget() = default;
