// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DepthSharing_h
#define isosurface_DepthSharing_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Compositing/FramePlanner.h"
#include "Ranks/Compositing/DisplayLayout.h"
#include "Surface/Drawing/SharedDepths.h"

#include <functional>

class vtkRenderState;

namespace isosurface
{

/// Has the mappers of a view leave out what is behind other ranks' triangles (SharedDepths).
class DepthSharing
{
public:
  /// Adds to `proposal`, the first choice of which is drawn, whether this rank can share depths in the next
  /// frame, and whether that pays. `isAllowed`: whether sharing is switched on.
  void Begin(const vtkRenderState* state, const PixelRectangle& display, bool isAllowed,
    FrameProposal& proposal);

  /// Draws the frame of `plan`. Collective if the plan shares depths.
  Status Draw(
    Communicator& communicator, const FramePlan& plan, const std::function<Status()>& draw);

private:
  SharedDepths Shared;
  bool CanShare = false; ///< in the frame that was begun last
};

} // namespace isosurface

#endif
