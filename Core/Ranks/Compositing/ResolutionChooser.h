// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ResolutionChooser_h
#define isosurface_ResolutionChooser_h

#include "Ranks/Compositing/FrameTimeModel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The resolutions to choose from: divisors 1, 2, 4, 8, 16.
constexpr std::size_t NumberOfResolutions = 5;
constexpr int GetResolutionDivisor(std::size_t resolution)
{
  return 1 << resolution;
}
/// The first resolution with at least this divisor; the last one if there is none.
constexpr std::size_t FindResolution(int divisor)
{
  std::size_t resolution = 0;
  while (resolution + 1 < NumberOfResolutions && GetResolutionDivisor(resolution) < divisor)
  {
    ++resolution;
  }
  return resolution;
}

/// What a rank would draw in the next frame.
struct RankWork
{
  std::int64_t Triangles = 0;
  std::array<std::int64_t, NumberOfResolutions> Samples{}; ///< of the viewport, by resolution
  double Importance = 1;                                   ///< more than 0; see GetImportance()
};

/**
 * How much a viewer looks at a rank's viewport: from 1 (behind all others, in the display's corner)
 * to 16 (in front of all others, at its center). `offset` is the distance of the viewport's center
 * from the display's center, relative to that of the corners. `depth` is where the rank's piece
 * begins between the nearest (0) and the farthest (1) piece.
 */
double GetImportance(double offset, double depth);

/**
 * Chooses the resolutions of all ranks such that frames keep a time budget. Less important ranks
 * lose resolution first, and large viewports before small ones: blocks get larger evenly, when
 * their areas are weighted by importance.
 *
 * A resolution is lowered as soon as a frame is expected to take too long. It is raised only if that
 * has been possible for several frames, so that images do not flicker. Deterministic: ranks that
 * are given the same numbers choose the same.
 */
class ResolutionChooser
{
public:
  /// The divisors by rank for a frame within `budget` seconds; the coarsest if there are none.
  std::vector<int> Choose(const std::vector<RankWork>& work, double budget);

  /// Learns from a frame that took `seconds` with these divisors, chosen here or not.
  void Learn(const std::vector<RankWork>& work, const std::vector<int>& divisors, double seconds);

private:
  static constexpr int PatientFrames = 2; ///< that allow more samples before resolutions are raised

  static FrameLoad Sum(
    const std::vector<RankWork>& work, const std::vector<std::size_t>& resolutions);
  std::vector<std::size_t> Refine(
    const std::vector<RankWork>& work, std::vector<std::size_t> resolutions, double seconds) const;

  FrameTimeModel Model;
  std::vector<std::size_t> Resolutions; ///< of the last choice
  int FramesThatAllowMore = 0;
};

} // namespace isosurface

#endif
