// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OcclusionCulling_h
#define isosurface_OcclusionCulling_h

#include "vtkNew.h"
#include "vtkOpenGLIndexBufferObject.h"

#include "Surface/Drawing/DepthPyramid.h"
#include "Surface/Drawing/VisibleRuns.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

class vtkActor;
class vtkOpenGLState;
class vtkRenderer;

namespace isosurface
{

/**
 * Draws the triangles of a surface without those that are outside of the image or behind others
 * (VisibleRuns). Indices of what is drawn are copied to a buffer of their own, so a mapper draws them
 * as any others.
 *
 * The image is that of all triangles in their order, to the last pixel. Of triangles that have the same
 * depth in a pixel, OpenGL shows the one that is drawn last. So before a later portion is drawn, it is
 * drawn where its depths are those of the image. The pixels that change then are drawn again at the
 * end, in the order of all triangles.
 */
class OcclusionCulling
{
public:
  using DrawIndices = std::function<void(vtkOpenGLIndexBufferObject* indices)>;

  /// Whether what is drawn now can be left out where something is in front of it: the framebuffer has
  /// one image of opaque triangles, and their depths can be read.
  static bool IsPossible(vtkRenderer* renderer, vtkActor* actor);
  /// Whether the processor draws, which takes long for each triangle.
  static bool IsSoftware();

  /// Takes another surface. Until its first image, that of the surface before tells what may be hidden.
  void Take(const TriangleMeasure& measure);

  /// Draws the surface. `all` has the indices of all proper triangles; draw() is called for those of
  /// each portion.
  void Draw(vtkRenderer* renderer, vtkActor* actor, vtkOpenGLIndexBufferObject* all,
    const DrawIndices& draw);

  /// How many triangles of the surface the last image needed.
  std::size_t GetDrawn() const { return this->Drawn; }
  /// Tells that all of so many were drawn, by somebody else.
  void SetDrawn(std::size_t triangles) { this->Drawn = triangles; }

  void ReleaseGraphicsResources();

private:
  using Colors = std::vector<std::uint32_t>;
  using Ranges = std::vector<VisibleRuns::Range>;

  /// The indices of some triangles.
  vtkOpenGLIndexBufferObject* CopyIndices(vtkOpenGLIndexBufferObject* all, const Ranges& triangles);
  void ReadDepths();
  void ReadColors(Colors& colors) const;
  /// Adds the pixels to Ties that change where triangles have the depths of the image.
  void FindTies(
    vtkOpenGLState* state, vtkOpenGLIndexBufferObject* indices, const DrawIndices& draw);
  void DrawTies(vtkOpenGLState* state, vtkOpenGLIndexBufferObject* all, const DrawIndices& draw);

  VisibleRuns Runs;
  std::array<double, 3> Centre{}; ///< of the surface, where drawn coordinates are 0
  vtkNew<vtkOpenGLIndexBufferObject> Some;
  std::size_t Room = 0; ///< bytes in it
  std::size_t Drawn = 0;
  std::array<int, 4> Viewport{};
  DepthPyramid Pyramid;
  std::vector<float> Depths;
  Colors Before;
  Colors After;
  std::vector<std::size_t> Ties; ///< places of pixels in the viewport
};

} // namespace isosurface

#endif
