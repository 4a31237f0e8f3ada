// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsosurfaceGeometryFilter
 * @brief   a vtkPVGeometryFilter that passes surfaces of triangles on as they are
 *
 * On one rank such a surface goes to the view without arrays of original ids, since all numbers are
 * the original ones. On several ranks it has those of the superclass, made by threads. Other
 * settings and other data are left to the superclass.
 */

#ifndef vtkIsosurfaceGeometryFilter_h
#define vtkIsosurfaceGeometryFilter_h

#include "vtkPVGeometryFilter.h"

class vtkIsosurfaceGeometryFilter : public vtkPVGeometryFilter
{
public:
  static vtkIsosurfaceGeometryFilter* New();
  vtkTypeMacro(vtkIsosurfaceGeometryFilter, vtkPVGeometryFilter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkIsosurfaceGeometryFilter() = default;
  ~vtkIsosurfaceGeometryFilter() override = default;

  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkIsosurfaceGeometryFilter(const vtkIsosurfaceGeometryFilter&) = delete;
  void operator=(const vtkIsosurfaceGeometryFilter&) = delete;
};

#endif
