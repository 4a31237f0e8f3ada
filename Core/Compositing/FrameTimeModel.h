// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FrameTimeModel_h
#define isosurface_FrameTimeModel_h

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// What a frame has to do, over all ranks.
struct FrameWork
{
  std::int64_t MostTriangles = 0; ///< of the rank that draws most of them
  std::int64_t MostSamples = 0;   ///< of the rank that draws most of them
  std::int64_t AllSamples = 0;
};

/**
 * Predicts the seconds of a frame from its work, and learns from frames. The seconds are taken to
 * be linear in the work: a constant, triangles and samples of the busiest rank (as if each had a
 * processor of its own), samples of all (as if they shared one, and for merging). The four
 * coefficients are followed by a Kalman filter as they wander, so the model knows them as well as
 * the frames tell them apart, and a change of a constant scene's pace arrives within three frames.
 *
 * A frame that takes much longer or shorter than predicted counts only if the one before did so,
 * too; alone it may have been another program's fault.
 *
 * After: R. E. Kalman, "A new approach to linear filtering and prediction problems", 1960.
 */
class FrameTimeModel
{
public:
  /// Of seconds that are not above 0, nothing is learned.
  void Learn(const FrameWork& work, double seconds);
  double Predict(const FrameWork& work) const;

  /// How much longer than predicted frames get: nineteen of twenty of the last 40 took at most so
  /// many times what was predicted, lone long ones included.
  double GetHighRatio() const;

private:
  static constexpr std::size_t Size = 4;
  using Vector = std::array<double, Size>;

  static Vector MakeFeatures(const FrameWork& work);
  bool IsLoneOutlier(double predicted, double seconds);

  // Seconds a frame, a million triangles, and a million samples. A software renderer's to begin
  // with: who starts at too low a resolution refines, who starts at too high a one waits.
  Vector Coefficients = { 0.02, 0.1, 0.02, 0.01 };
  std::array<Vector, Size> Covariance = { { { 0.01, 0, 0, 0 }, { 0, 0.04, 0, 0 },
    { 0, 0, 0.001, 0 }, { 0, 0, 0, 0.001 } } };
  static constexpr std::size_t NumberOfRatios = 40;
  std::vector<double> Ratios = std::vector<double>(NumberOfRatios, 1.0); ///< of the last frames
  std::int64_t FramesLearned = 0;
  bool HasLearned = false;
  int Outlier = 0; ///< of the last frame: 1 if it was far too long, -1 if far too short
};

} // namespace isosurface

#endif
