// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OcclusionCulling_h
#define isosurface_OcclusionCulling_h

#include "SavedImage.h"

#include "vtkNew.h"
#include "vtkOpenGLIndexBufferObject.h"
#include "vtkType.h"

#include "Surface/Drawing/DepthPyramid.h"
#include "Surface/Drawing/VisibleRuns.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

class vtkActor;
class vtkMapper;
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
 *
 * With SharedDepths it also leaves out what is behind the triangles of other ranks, and draws all at once.
 *
 * Else, within a DrawingBudget, it stops when the time is over, and goes on in the next image, where it
 * was, if nothing has changed: the view, what was drawn before the surface, and how it looks.
 */
class OcclusionCulling
{
public:
  using DrawIndices = std::function<void(vtkOpenGLIndexBufferObject* indices)>;

  /// Whether hidden triangles can be left out: `actor` is opaque, the framebuffer has one image, and
  /// its depths can be read.
  static bool IsPossible(vtkRenderer* renderer, vtkActor* actor);
  /// Whether the processor draws, which takes long for each triangle.
  static bool IsSoftware();

  /// Takes another surface. In its first image, the depths of the last surface tell what may be hidden.
  void Take(const TriangleMeasure& measure);

  /// Draws the surface of `mapper`, which were changed last at `changed`. `all` has the indices of all
  /// proper triangles; draw() is called for those of each portion. Collective with SharedDepths.
  void Draw(vtkRenderer* renderer, vtkActor* actor, vtkMapper* mapper, vtkMTimeType changed,
    vtkOpenGLIndexBufferObject* all, const DrawIndices& draw);

  /// Whether the next image may go on where the last one stopped.
  bool IsAmidPortions() const { return !this->Image.IsEmpty(); }

  /// How many triangles of the surface the last image needed.
  std::size_t GetDrawn() const { return this->Drawn; }
  /// Records that the caller drew `triangles` triangles, all of the surface.
  void SetDrawn(std::size_t triangles) { this->Drawn = triangles; }

  void ReleaseGraphicsResources();

private:
  using Colors = std::vector<std::uint32_t>;
  using Ranges = std::vector<VisibleRuns::Range>;

  /// Why triangles are drawn.
  enum class Stage
  {
    First,   ///< they are the first ones of an image
    Further, ///< they may be visible beside those before
    Again,   ///< there are too many ties
    End
  };

  /// What an image depends on. Two images that have the same are the same, as far as the surface goes.
  struct Conditions
  {
    std::array<double, 16> ModelToClip{};
    std::array<double, 16> ModelToWorld{};
    std::array<int, 4> Viewport{};
    vtkMTimeType Changed = 0; ///< the surface, its look, or the light
    const void* BackfaceProperty = nullptr;
    std::vector<double> ClippingPlanes;
    Colors ColorsBefore; ///< without the surface, as the next
    std::vector<float> DepthsBefore;

    bool operator==(const Conditions& other) const;
  };

  Conditions FindConditions(vtkRenderer* renderer, vtkActor* actor, vtkMTimeType changed) const;
  void Begin(const std::array<double, 16>& modelToClip);
  /// Finds what is drawn next, when nothing is waiting.
  void FindNext(vtkOpenGLIndexBufferObject* all, const DrawIndices& draw);
  /// Draws waiting triangles for about `seconds`.
  void DrawFor(double seconds, vtkOpenGLIndexBufferObject* all, const DrawIndices& draw);
  void DrawPortion(
    vtkOpenGLIndexBufferObject* all, const Ranges& triangles, const DrawIndices& draw);

  /// The indices of some triangles.
  vtkOpenGLIndexBufferObject* CopyIndices(vtkOpenGLIndexBufferObject* all, const Ranges& triangles);
  /// Adds the pixels to Ties that change where triangles have the depths of the image.
  void FindTies(vtkOpenGLIndexBufferObject* indices, const DrawIndices& draw);
  void DrawTies(vtkOpenGLIndexBufferObject* all, const DrawIndices& draw);

  VisibleRuns Runs;
  vtkMapper* Mapper = nullptr;    ///< while it is drawn, as State
  std::array<double, 3> Centre{}; ///< of the surface, where drawn coordinates are 0
  vtkNew<vtkOpenGLIndexBufferObject> Some;
  std::size_t Room = 0; ///< bytes in it
  std::size_t Drawn = 0;
  std::array<int, 4> Viewport{};
  DepthPyramid Pyramid;
  std::vector<float> Depths;
  Colors Before;
  Colors After;
  std::vector<std::size_t> Ties;   ///< places of pixels in the viewport
  vtkOpenGLState* State = nullptr; ///< while it is drawn

  Stage Now = Stage::End;
  Ranges Waiting;
  SavedImage Image; ///< so far, of Known; empty if the next one begins anew
  Conditions Known;
  double Rate = 5e6; ///< triangles a second, as measured
};

} // namespace isosurface

#endif
