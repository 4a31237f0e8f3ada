// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FramePart_h
#define isosurface_FramePart_h

#include "Base/Communicator.h"
#include "Compositing/ResolutionChooser.h"
#include "Compositing/Viewport.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// What a rank tells all others before they draw a frame.
struct FramePart
{
  /// One, or one for each resolution of ResolutionChooser, if that is to choose among them.
  std::vector<Viewport> Choices;
  std::int64_t Triangles = 0;
  double NearDistance = 0; ///< from the camera, where the part begins
  double FarDistance = 0;  ///< and ends
  double LastSeconds = 0;  ///< of the last frame; 0 if it is nothing to learn from
  double Budget = 0;       ///< seconds of this frame, if Choices are several
  bool WantsDepths = false;

  Message Pack() const;
  /// Of what Pack() made, by a rank of the same program.
  static FramePart Unpack(const Message& bytes);
};

/// What all ranks would draw, for ResolutionChooser; by rank, as `parts` are.
std::vector<RankWork> MakeRankWork(
  const std::vector<FramePart>& parts, const PixelRectangle& display);

} // namespace isosurface

#endif
