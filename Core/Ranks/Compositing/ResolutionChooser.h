// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ResolutionChooser_h
#define isosurface_ResolutionChooser_h

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The work of a frame, over all ranks.
struct FrameLoad
{
  std::int64_t MaximumTriangles = 0; ///< of a rank
  std::int64_t MaximumSamples = 0;   ///< of a rank
  std::int64_t AllSamples = 0;
};

/**
 * Predicts the seconds of a frame from its work, and learns from measured frames. The model is
 * linear: a constant; triangles and samples of the busiest rank, as if each rank had a processor of
 * its own; samples of all ranks, as if they shared one, and for merging. A Kalman filter tracks the
 * four coefficients. When the speed of a constant scene changes, the model follows within three
 * frames.
 *
 * A frame that takes much longer or shorter than predicted is an outlier. It is ignored unless the
 * frame before was an outlier as well: other programs may have caused it.
 *
 * After: R. E. Kalman, "A new approach to linear filtering and prediction problems", 1960.
 */
class FrameTimeModel
{
public:
  /// Learns nothing if the seconds are not positive.
  void Learn(const FrameLoad& work, double seconds);
  double Predict(const FrameLoad& work) const;

  /// The ratio of measured to predicted seconds that nineteen of twenty of the last 40 frames did
  /// not exceed, outliers included.
  double GetHighRatio() const;

private:
  static constexpr std::size_t Size = 4;
  using Vector = std::array<double, Size>;

  static Vector MakeFeatures(const FrameLoad& work);
  bool IsLoneOutlier(double predicted, double seconds);

  // Seconds a frame, a million triangles, and a million samples. At first those of a software
  // renderer: it is better to start at too low a resolution than to wait for the first frames.
  Vector Coefficients = { 0.02, 0.1, 0.02, 0.01 };
  std::array<Vector, Size> Covariance = { { { 0.01, 0, 0, 0 }, { 0, 0.04, 0, 0 },
    { 0, 0, 0.001, 0 }, { 0, 0, 0, 0.001 } } };
  static constexpr std::size_t NumberOfRatios = 40;
  std::vector<double> Ratios = std::vector<double>(NumberOfRatios, 1.0); ///< of the last frames
  std::int64_t FramesLearned = 0;
  bool HasLearned = false;
  int Outlier = 0; ///< of the last frame: 1 if it was too long for one, -1 if too short
};

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
