// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsosurfaceMapperHelper
 * @brief   makes the buffers of vtkIsosurfaceMapper
 */

#ifndef vtkIsosurfaceMapperHelper_h
#define vtkIsosurfaceMapperHelper_h

#include "MeasuredTriangles.h" // For what is shared
#include "SurfaceBuffers.h"    // For a member
#include "vtkVersionMacros.h"  // For the superclass

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
#  include "vtkOpenGLBatchedPolyDataMapper.h"
#  define vtkIsosurfaceMapperHelperSuperclass vtkOpenGLBatchedPolyDataMapper
#else
#  include "vtkCompositePolyDataMapper2.h" // VTK 9.1: the next one needs its includes

#  include "OpenGLFunctions.h"

#  include "vtkCompositeMapperHelper2.h"
#  define vtkIsosurfaceMapperHelperSuperclass vtkCompositeMapperHelper2
#endif

#include <memory> // For what is shared

namespace isosurface
{
class OcclusionCulling;
}

class vtkIsosurfaceMapperHelper : public vtkIsosurfaceMapperHelperSuperclass
{
public:
  static vtkIsosurfaceMapperHelper* New();
  vtkTypeMacro(vtkIsosurfaceMapperHelper, vtkIsosurfaceMapperHelperSuperclass);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// What the mapper has beyond a helper: what measures the surface, and what knows its last image.
  void Share(const std::shared_ptr<isosurface::MeasuredTriangles>& triangles,
    const std::shared_ptr<isosurface::OcclusionCulling>& culling)
  {
    this->Triangles = triangles;
    this->Culling = culling;
  }

  void ReleaseGraphicsResources(vtkWindow* window) override;

protected:
  vtkIsosurfaceMapperHelper() = default;
  ~vtkIsosurfaceMapperHelper() override = default;

  void BuildBufferObjects(vtkRenderer* renderer, vtkActor* actor) override;
  void RenderPieceDraw(vtkRenderer* renderer, vtkActor* actor) override;
  void BuildSelectionIBO(
    vtkPolyData* surface, std::vector<unsigned int> (&indices)[4], vtkIdType offset) override;

private:
  vtkIsosurfaceMapperHelper(const vtkIsosurfaceMapperHelper&) = delete;
  void operator=(const vtkIsosurfaceMapperHelper&) = delete;

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  using Block = GLBatchElement;
#else
  using Block = vtkCompositeMapperHelperData;
#endif

  /// The only block of this helper; null if it has others.
  Block* GetBlockAlone();
  /// Whether the buffers can be made here; if so, Triangles has measured the block's surface.
  bool Covers(vtkRenderer* renderer, vtkActor* actor, const Block& block);
  void ReleaseOwnBuffers();
  void BuildBuffersOfBlock(vtkRenderer* renderer, vtkActor* actor, Block& block);
  /// Sets Colors, or ColorCoordinates and the texture, as MapScalars does.
  void MapColors(vtkPolyData* surface);
  bool MapColorsToTexture(vtkPolyData* surface);
  bool MapColorsOfRuns(vtkPolyData* surface);
  /// The point array that gives the colors; null if it is not one of numbers, chosen by its name.
  vtkDataArray* FindNamedScalars(vtkPolyData* surface) const;
  /// Makes the buffer of an attribute that the group knows as long as the surface. The values are
  /// unwritten: write(first, last, values) writes those of points [first, last).
  template <typename WriteT>
  void MakeVertexBuffer(
    const char* attribute, std::size_t components, std::size_t tuples, WriteT write);
  void MakeVertices(vtkRenderer* renderer, vtkActor* actor, vtkPolyData* surface);
  void MakeIndices(vtkOpenGLIndexBufferObject* buffer, vtkPolyData* surface);
  /// Whether hidden triangles may be left out.
  bool CanCull(vtkRenderer* renderer, vtkActor* actor);

  std::shared_ptr<isosurface::MeasuredTriangles> Triangles;
  /// The array that colors the surface by a texture, if texture coordinates are written here; used
  /// only while buffers are made.
  vtkDataArray* ColorValues = nullptr;
  std::shared_ptr<isosurface::OcclusionCulling> Culling;
  bool HasOwnBuffers = false; ///< whether the buffers are not those of the superclass
  isosurface::SurfaceBuffers Buffers;
  int Threads = 1;
};

#endif
