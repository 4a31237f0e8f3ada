// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSpinBoxWidget
 * @brief   a whole number in a panel as a spin box
 *
 * ParaView gives a property with a minimum and a maximum a slider, on which no hand finds one value
 * of tens of thousands, and an IdTypeVectorProperty nothing at all. In a panel:
 * panel_widget="spin_box" at a property of one integer with an IntRangeDomain.
 */

#ifndef pqSpinBoxWidget_h
#define pqSpinBoxWidget_h

#include "pqPropertyWidget.h"

class pqSpinBoxWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;

public:
  pqSpinBoxWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);
};

#endif
