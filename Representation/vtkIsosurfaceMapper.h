// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsosurfaceMapper
 * @brief   draws surfaces of triangles from their arrays as they are
 *
 * A vtkCompositePolyDataMapper2 that makes the buffers of a single vtkPolyData of triangles by
 * threads, without asking for one cell after the other: shifted points, indices without degenerate
 * triangles, texture coordinates of scalars. The buffers hold what the superclass's hold.
 *
 * Everything else is left to the superclass: several blocks, other cells, wireframe, points, edges,
 * textures, selections of points, coordinates that follow the camera.
 */

#ifndef vtkIsosurfaceMapper_h
#define vtkIsosurfaceMapper_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkCompositePolyDataMapper2.h"

#include <memory> // For what is shared

namespace isosurface
{
class MeasuredTriangles;
}

class ISOSURFACEREPRESENTATION_EXPORT vtkIsosurfaceMapper : public vtkCompositePolyDataMapper2
{
public:
  static vtkIsosurfaceMapper* New();
  vtkTypeMacro(vtkIsosurfaceMapper, vtkCompositePolyDataMapper2);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// What measures the surface. Others that need the measure use this, so that it is made once.
  const std::shared_ptr<isosurface::MeasuredTriangles>& GetTriangles() const
  {
    return this->Triangles;
  }

protected:
  vtkIsosurfaceMapper();
  ~vtkIsosurfaceMapper() override;

  vtkCompositeMapperHelper2* CreateHelper() override;

private:
  vtkIsosurfaceMapper(const vtkIsosurfaceMapper&) = delete;
  void operator=(const vtkIsosurfaceMapper&) = delete;

  std::shared_ptr<isosurface::MeasuredTriangles> Triangles;
};

#endif
