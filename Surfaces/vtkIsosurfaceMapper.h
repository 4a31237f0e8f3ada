// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsosurfaceMapper
 * @brief   draws surfaces of triangles from their arrays as they are
 *
 * A vtkCompositePolyDataMapper (before VTK 9.3: vtkCompositePolyDataMapper2) that makes the buffers of
 * a single vtkPolyData of triangles by threads, without asking for one cell after the other: shifted points, indices without degenerate
 * triangles, texture coordinates of scalars. The buffers hold what the superclass's hold.
 *
 * Everything else is left to the superclass: several blocks, other cells, wireframe, points, edges,
 * textures, selections of points, coordinates that follow the camera.
 */

#ifndef vtkIsosurfaceMapper_h
#define vtkIsosurfaceMapper_h

#include "IsosurfaceSurfacesModule.h" // For export macro
#include "vtkVersionMacros.h"         // For the superclass

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
#  include "vtkCompositePolyDataMapper.h"
#  define vtkIsosurfaceMapperSuperclass vtkCompositePolyDataMapper
#else
#  include "vtkCompositePolyDataMapper2.h"
#  define vtkIsosurfaceMapperSuperclass vtkCompositePolyDataMapper2
#endif

#include <memory> // For what is shared

namespace isosurface
{
class MeasuredTriangles;
class OcclusionCulling;
}

class ISOSURFACESURFACES_EXPORT vtkIsosurfaceMapper : public vtkIsosurfaceMapperSuperclass
{
public:
  static vtkIsosurfaceMapper* New();
  vtkTypeMacro(vtkIsosurfaceMapper, vtkIsosurfaceMapperSuperclass);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// A surface of fewer triangles is drawn at once, even within a budget.
  enum
  {
    TRIANGLES_OF_PORTIONS = 150000
  };

  /// When hidden triangles are left out.
  enum
  {
    NEVER = 0,
    SOFTWARE = 1, ///< where the processor draws, which takes long for each triangle
    ALWAYS = 2
  };

  ///@{
  /**
   * Whether triangles behind others, or outside of the image, are left out: of opaque surfaces of more
   * than half a million triangles, or of TRIANGLES_OF_PORTIONS within a budget. The image is the same, to
   * the last pixel. Default: SOFTWARE.
   */
  vtkSetClampMacro(OcclusionCulling, int, NEVER, ALWAYS);
  vtkGetMacro(OcclusionCulling, int);
  ///@}

  /// How many triangles the last image needed: all, unless some were left out.
  vtkIdType GetNumberOfDrawnTriangles();

  ///@{
  /**
   * Until EndBudget() large surfaces are drawn for about `seconds` an image, where hidden triangles
   * can be left out; otherwise as a whole. EndBudget() returns whether all surfaces were whole. The
   * next image goes on where the last one ended, if nothing has changed: so an image that nobody
   * sees (vtkRenderWindow::SwapBuffersOff) can be drawn in portions, between which a program
   * answers its user. The image after it, without a budget, is whole, and takes what is drawn
   * already. For all mappers.
   */
  static void BeginBudget(double seconds);
  static bool EndBudget();
  ///@}

  /// What measures the surface. Others that need the measure use this, so that it is made once.
  const std::shared_ptr<isosurface::MeasuredTriangles>& GetTriangles() const
  {
    return this->Triangles;
  }

protected:
  vtkIsosurfaceMapper();
  ~vtkIsosurfaceMapper() override;

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  vtkCompositePolyDataMapperDelegator* CreateADelegator() override;
#else
  vtkCompositeMapperHelper2* CreateHelper() override;
#endif

private:
  vtkIsosurfaceMapper(const vtkIsosurfaceMapper&) = delete;
  void operator=(const vtkIsosurfaceMapper&) = delete;

  std::shared_ptr<isosurface::MeasuredTriangles> Triangles;
  std::shared_ptr<isosurface::OcclusionCulling> Culling;
  int OcclusionCulling;
};

#endif
