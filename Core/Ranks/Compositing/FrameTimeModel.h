// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FrameTimeModel_h
#define isosurface_FrameTimeModel_h

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

} // namespace isosurface

#endif
