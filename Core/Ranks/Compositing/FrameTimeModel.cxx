// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/FrameTimeModel.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

// The standard deviation of the seconds of equal frames, relative to these seconds.
constexpr double MeasurementNoise = 0.1;
// The variance that the constant gains from frame to frame, relative to the noise: about half of what
// a frame tells is believed at once. The other coefficients, which are the machine's, change less:
// their standard deviation a frame, relative to their values.
constexpr double ConstantDrift = 0.5;
constexpr double CoefficientDrift = 0.02;
// How much longer or shorter than predicted an outlier is.
constexpr double OutlierFactor = 1.5;
// Ratios of the first frames are not kept: they measure the initial coefficients, not the machine.
constexpr std::int64_t FirstFrames = 3;

} // namespace

FrameTimeModel::Vector FrameTimeModel::MakeFeatures(const FrameLoad& work)
{
  constexpr double Million = 1e6;
  return { 1.0, static_cast<double>(work.MaximumTriangles) / Million,
    static_cast<double>(work.MaximumSamples) / Million,
    static_cast<double>(work.AllSamples) / Million };
}

double FrameTimeModel::Predict(const FrameLoad& work) const
{
  const Vector features = MakeFeatures(work);
  double seconds = 0;
  for (std::size_t index = 0; index < Size; ++index)
  {
    seconds += features[index] * this->Coefficients[index];
  }
  return seconds;
}

double FrameTimeModel::GetHighRatio() const
{
  std::vector<double> ratios = this->Ratios;
  const auto high = ratios.begin() + NumberOfRatios * 19 / 20 - 1;
  std::nth_element(ratios.begin(), high, ratios.end());
  return *high;
}

bool FrameTimeModel::IsLoneOutlier(double predicted, double seconds)
{
  const int outlier = seconds > predicted * OutlierFactor ? 1
    : seconds * OutlierFactor < predicted                 ? -1
                                                          : 0;
  const bool isAlone = this->HasLearned && outlier != 0 && outlier != this->Outlier;
  this->Outlier = outlier;
  this->HasLearned = true;
  return isAlone;
}

void FrameTimeModel::Learn(const FrameLoad& work, double seconds)
{
  if (!(seconds > 0) || !std::isfinite(seconds))
  {
    return;
  }
  const double predicted = this->Predict(work);
  if (this->FramesLearned >= FirstFrames && predicted > 0)
  {
    this->Ratios[static_cast<std::size_t>(this->FramesLearned) % NumberOfRatios] =
      seconds / predicted;
  }
  ++this->FramesLearned;
  if (this->IsLoneOutlier(predicted, seconds))
  {
    return;
  }

  const double noise = std::pow(MeasurementNoise * seconds, 2);
  this->Covariance[0][0] += ConstantDrift * noise;
  for (std::size_t index = 1; index < Size; ++index)
  {
    this->Covariance[index][index] += std::pow(CoefficientDrift * this->Coefficients[index], 2);
  }

  const Vector features = MakeFeatures(work);
  Vector gain{};
  double uncertainty = noise;
  for (std::size_t row = 0; row < Size; ++row)
  {
    for (std::size_t column = 0; column < Size; ++column)
    {
      gain[row] += this->Covariance[row][column] * features[column];
    }
    uncertainty += features[row] * gain[row];
  }
  const Vector covered = gain; // covariance times features
  for (std::size_t row = 0; row < Size; ++row)
  {
    gain[row] /= uncertainty;
    // No work takes negative time.
    this->Coefficients[row] =
      std::max(0.0, this->Coefficients[row] + gain[row] * (seconds - predicted));
  }
  for (std::size_t row = 0; row < Size; ++row)
  {
    for (std::size_t column = 0; column < Size; ++column)
    {
      this->Covariance[row][column] -= gain[row] * covered[column];
    }
  }
}

} // namespace isosurface
