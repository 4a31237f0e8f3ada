// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSlicePlaneWidget
 * @brief   ParaView's plane in the Properties panel, whose handle is not in the view at first
 *
 * The handle would cover the slice that stands in the plane. Show Plane brings it.
 *
 * In a panel: panel_widget="slice_plane" at a group of the functions Origin and Normal.
 */

#ifndef pqSlicePlaneWidget_h
#define pqSlicePlaneWidget_h

#include "pqImplicitPlanePropertyWidget.h"

class pqSlicePlaneWidget : public pqImplicitPlanePropertyWidget
{
  Q_OBJECT
  typedef pqImplicitPlanePropertyWidget Superclass;

public:
  pqSlicePlaneWidget(vtkSMProxy* proxy, vtkSMPropertyGroup* group, QWidget* parent = nullptr);
};

#endif
