// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SceneProjection_h
#define isosurface_SceneProjection_h

#include "Ranks/Compositing/FramePlanner.h"
#include "Ranks/Compositing/DisplayLayout.h"

#include "vtkSmartPointer.h"

#include <vector>

class vtkCamera;
class vtkMapper;
class vtkMatrix4x4;
class vtkRenderState;

namespace isosurface
{

/// The camera's projection to a display of this size, to OpenGL's clip coordinates.
vtkSmartPointer<vtkMatrix4x4> MakeProjection(vtkCamera* camera, const PixelRectangle& display);

/**
 * What this rank would draw of a render state: a viewport for each of the divisors, and what they
 * all have in common, triangles and distances from the camera. All else keeps its defaults.
 *
 * A viewport covers the bounds of the visible props, lines and points in their full width included.
 * If the bounds of a prop do not tell where it draws, the viewport is the whole display.
 * `isFullDisplay` makes all viewports the whole display.
 */
FrameProposal MakeProposal(const vtkRenderState* state, const PixelRectangle& display,
  const std::vector<int>& divisors, bool isFullDisplay);

/// The mapper of the actor that is drawn last on this rank; null if there is none, or if that is another
/// prop, or with translucent props or volumes.
const vtkMapper* FindLastMapper(const vtkRenderState* state);

} // namespace isosurface

#endif
