// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ResolutionChooser.h"

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

// Resolutions are kept unless they are expected to take this much longer than the target.
constexpr double Tolerance = 1.05;

// The seconds to predict for a frame, such that nineteen of twenty frames take at most 1.1 times the
// budget, provided that predictions stay as accurate as they were.
double GetTarget(double budget, double highRatio)
{
  constexpr double Allowed = 1.1;
  return budget * std::clamp(Allowed / (Tolerance * highRatio), 0.5, 1.0);
}

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

double GetImportance(double offset, double depth)
{
  const double middle = 1 - std::clamp(offset, 0.0, 1.0);
  const double front = 1 - std::clamp(depth, 0.0, 1.0);
  return std::exp2(2 * middle + 2 * front);
}

FrameLoad ResolutionChooser::Sum(
  const std::vector<RankWork>& work, const std::vector<std::size_t>& resolutions)
{
  FrameLoad sum;
  for (std::size_t rank = 0; rank < work.size(); ++rank)
  {
    const std::int64_t samples = work[rank].Samples[resolutions[rank]];
    sum.MaximumTriangles = std::max(sum.MaximumTriangles, work[rank].Triangles);
    sum.MaximumSamples = std::max(sum.MaximumSamples, samples);
    sum.AllSamples += samples;
  }
  return sum;
}

// Halves the blocks of one rank after the other as long as the frame fits. The next rank is the one
// with the maximum product of block area and importance.
std::vector<std::size_t> ResolutionChooser::Refine(
  const std::vector<RankWork>& work, std::vector<std::size_t> resolutions, double seconds) const
{
  std::vector<bool> isDone(work.size(), false);
  for (;;)
  {
    std::size_t best = work.size();
    double bestWeight = 0;
    for (std::size_t rank = 0; rank < work.size(); ++rank)
    {
      const double divisor = GetResolutionDivisor(resolutions[rank]);
      const double weight = work[rank].Importance * divisor * divisor;
      if (!isDone[rank] && resolutions[rank] > 0 && weight > bestWeight)
      {
        best = rank;
        bestWeight = weight;
      }
    }
    if (best == work.size())
    {
      return resolutions;
    }
    --resolutions[best];
    if (this->Model.Predict(Sum(work, resolutions)) > seconds)
    {
      ++resolutions[best];
      isDone[best] = true; // another rank may have fewer samples
    }
  }
}

std::vector<int> ResolutionChooser::Choose(const std::vector<RankWork>& work, double budget)
{
  const double target = GetTarget(budget, this->Model.GetHighRatio());
  const std::vector<std::size_t> coarsest(work.size(), NumberOfResolutions - 1);
  const std::vector<std::size_t> best = this->Refine(work, coarsest, target);
  const bool isFirst = this->Resolutions.size() != work.size();
  const bool isTooMuch =
    isFirst || this->Model.Predict(Sum(work, this->Resolutions)) > Tolerance * target;
  const bool allowsMore =
    !isFirst && Sum(work, best).AllSamples > Sum(work, this->Resolutions).AllSamples;
  this->FramesThatAllowMore = allowsMore ? this->FramesThatAllowMore + 1 : 0;
  if (isTooMuch || this->FramesThatAllowMore > PatientFrames)
  {
    this->Resolutions = best;
    this->FramesThatAllowMore = 0;
  }

  std::vector<int> divisors;
  for (const std::size_t resolution : this->Resolutions)
  {
    divisors.push_back(GetResolutionDivisor(resolution));
  }
  return divisors;
}

void ResolutionChooser::Learn(
  const std::vector<RankWork>& work, const std::vector<int>& divisors, double seconds)
{
  std::vector<std::size_t> resolutions;
  resolutions.reserve(divisors.size());
  for (const int divisor : divisors)
  {
    resolutions.push_back(FindResolution(divisor));
  }
  if (resolutions.size() == work.size())
  {
    this->Model.Learn(Sum(work, resolutions), seconds);
  }
}

} // namespace isosurface
