// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ResolutionChooser_h
#define isosurface_ResolutionChooser_h

#include "Compositing/FrameTimeModel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The resolutions to choose from: divisors 1, 2, 4, 8, 16.
constexpr std::size_t NumberOfResolutions = 5;
constexpr int GetResolutionDivisor(std::size_t index)
{
  return 1 << index;
}

/// What a rank would draw in the next frame.
struct RankWork
{
  std::int64_t Triangles = 0;
  /// By resolution: samples of the viewport.
  std::array<std::int64_t, NumberOfResolutions> Samples{};
  /// How much of the viewer's attention is there, more than 0; see GetImportance().
  double Importance = 1;
};

/**
 * The importance of a part of the picture: from 1 (behind all others, in the display's corner) to
 * 16 (before all others, in its middle).
 *
 * `offset` is the distance of the part's middle from the display's, as a share of that of the
 * display's corner; `depth` where the part begins between the nearest (0) and the farthest (1)
 * part.
 */
double GetImportance(double offset, double depth);

/**
 * Chooses each rank's resolution such that frames take the time that is given for them, from what
 * the last frames took. Parts that matter less, and large ones before small ones, lose resolution
 * first: the picture gets coarser evenly, if blocks are weighed with their importance.
 *
 * Resolution goes down as soon as a frame is expected to take too long; it goes up only if that has
 * been possible for several frames, so that it does not flicker. Deterministic: ranks that were
 * given the same numbers choose the same.
 */
class ResolutionChooser
{
public:
  /// By rank: divisors for a frame within `budget` seconds; the coarsest ones if there is none.
  std::vector<int> Choose(const std::vector<RankWork>& work, double budget);

  /// Tells what a frame took that was drawn with these divisors, chosen here or not.
  void Learn(const std::vector<RankWork>& work, const std::vector<int>& divisors, double seconds);

private:
  static constexpr int PatientFrames = 2;

  static FrameWork Sum(
    const std::vector<RankWork>& work, const std::vector<std::size_t>& resolutions);
  std::vector<std::size_t> Refine(
    const std::vector<RankWork>& work, std::vector<std::size_t> resolutions, double seconds) const;

  FrameTimeModel Model;
  std::vector<std::size_t> Resolutions; ///< of the last choice
  int FramesThatAllowMore = 0;
};

} // namespace isosurface

#endif
