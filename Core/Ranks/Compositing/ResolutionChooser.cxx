// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ResolutionChooser.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

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
