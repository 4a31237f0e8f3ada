// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FramePlanner_h
#define isosurface_FramePlanner_h

#include "Ground/Base/Communicator.h"
#include "Ranks/Compositing/ResolutionChooser.h"
#include "Ranks/Compositing/DisplayLayout.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// What a rank would draw in the next frame. Every rank sends its own to all others.
struct FrameProposal
{
  /// The viewport; or one for each resolution of ResolutionChooser, from which one is chosen.
  std::vector<Viewport> Choices;
  std::int64_t Triangles = 0;
  double NearDistance = 0; ///< the rank's minimum distance from the camera, in world units
  double FarDistance = 0;  ///< its maximum distance
  double LastSeconds = 0;  ///< what the last frame took; 0 if nothing is to be learned from it
  double Budget = 0;       ///< seconds for this frame; counts if there are several Choices
  bool WantsDepths = false;
  bool CanShareDepths = false; ///< while ranks draw, to leave out what is behind others' triangles
  bool WantsSharedDepths = false; ///< whether this rank would leave out something

  Message Pack() const;
  /// Reads what Pack() wrote; zeros where bytes are missing.
  static FrameProposal Unpack(const Message& bytes);
};

/// What the ranks draw in a frame.
struct FramePlan
{
  std::vector<Viewport> Viewports; ///< by rank
  bool WantsDepths = false;        ///< whether some rank does
  /// Whether some rank wants shared depths, all can, and all draw in full resolution.
  bool SharesDepths = false;
};

/**
 * Agrees on the viewports of all ranks before each frame. The viewports are those that the ranks
 * propose, or, if all propose one for each resolution, those that keep the budget of rank 0 (see
 * ResolutionChooser). Learns from each frame what frames take.
 *
 * One all-gather of some hundred bytes a frame.
 */
class FramePlanner
{
public:
  /// Collective. `display` is the extent of the display, the same on all ranks.
  FramePlan Plan(
    Communicator& communicator, const FrameProposal& mine, const PixelRectangle& display);

  /// The last frame is not one to learn from. Collective, in that all ranks call it or none.
  void ForgetLastFrame() { this->LastWork.clear(); }

private:
  void Learn(const std::vector<FrameProposal>& proposals);

  ResolutionChooser Chooser;
  std::vector<RankWork> LastWork; ///< of the last frame, by rank; empty if there is none
  std::vector<int> LastDivisors;  ///< likewise
};

} // namespace isosurface

#endif
