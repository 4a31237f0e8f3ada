// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqRegionBoxWidget
 * @brief   a box of the world in the Properties panel and the view
 *
 * ParaView's interactive box with Position and Scale as they stand: the low corner and the lengths.
 * (With the input in its group, ParaView takes Scale as a factor of the input's bounds, as Transform
 * wants it.) Reset Bounds makes it the box of the proxy's input, or, of readers, of their own data.
 *
 * In a panel: panel_widget="region_box" at a group of the functions Position and Scale.
 */

#ifndef pqRegionBoxWidget_h
#define pqRegionBoxWidget_h

#include "pqBoxPropertyWidget.h"

class pqRegionBoxWidget : public pqBoxPropertyWidget
{
  Q_OBJECT
  typedef pqBoxPropertyWidget Superclass;

public:
  pqRegionBoxWidget(vtkSMProxy* proxy, vtkSMPropertyGroup* group, QWidget* parent = nullptr);

private Q_SLOTS:
  void FollowInput();
};

#endif
