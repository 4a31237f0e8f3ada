// SPDX-License-Identifier: BSD-3-Clause
#include "pqSlicePlaneWidget.h"

#include <QCheckBox>

pqSlicePlaneWidget::pqSlicePlaneWidget(
  vtkSMProxy* proxy, vtkSMPropertyGroup* group, QWidget* parent)
  : Superclass(proxy, group, parent)
{
  if (auto* shown = this->findChild<QCheckBox*>("show3DWidget"))
  {
    shown->setChecked(false);
  }
}
