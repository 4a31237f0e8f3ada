// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ExtractionRate.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace isosurface
{
namespace
{

/// The number of extractions remembered; few, so that a change of disk or load shows soon.
constexpr std::size_t Memory = 16;

/// Errors of less than this do not matter.
constexpr double Tolerance = 5e-3;

/// The weight of the usual rates against that of an observation.
constexpr double UsualWeight = 1e-3;

/// The maximum factor between this machine and a usual one.
constexpr double MaximumFactor = 1e4;

/// Sweeps of coordinate descent, which converges much earlier.
constexpr int Sweeps = 100;

} // namespace

ExtractionRate::Terms ExtractionRate::Count(const ExtractionWork& work)
{
  return { 1, work.Blocks, work.SampleBytes, work.BlocksRead, work.ReadBytes, work.Triangles };
}

double ExtractionRate::Predict(const ExtractionWork& work) const
{
  const Terms counts = Count(work);
  double seconds = std::inner_product(counts.begin(), counts.end(), this->Rates.begin(), 0.0);
  for (const std::size_t kind : ReadKinds)
  {
    const double untried = std::max(0.0, counts[kind] - this->FindMaximum(kind));
    seconds += untried * std::max(0.0, UsualRates[kind] - this->Rates[kind]);
  }
  return seconds;
}

void ExtractionRate::Observe(const ExtractionWork& work, double seconds)
{
  if (this->Observations.size() == Memory)
  {
    this->Observations.erase(this->Observations.begin());
  }
  this->Observations.push_back({ Count(work), seconds });
  this->Fit();
}

double ExtractionRate::FindMaximum(std::size_t kind) const
{
  double maximum = 0;
  for (const Observation& seen : this->Observations)
  {
    maximum = std::max(maximum, seen.Counts[kind]);
  }
  return maximum;
}

/// The median of the ratios of measured to usual seconds.
double ExtractionRate::FindSpeed() const
{
  std::vector<double> factors;
  for (const Observation& seen : this->Observations)
  {
    const double usual =
      std::inner_product(seen.Counts.begin(), seen.Counts.end(), UsualRates.begin(), 0.0);
    factors.push_back((seen.Seconds + Tolerance) / (usual + Tolerance));
  }
  const auto middle = factors.begin() + static_cast<std::ptrdiff_t>(factors.size() / 2);
  std::nth_element(factors.begin(), middle, factors.end());
  return std::clamp(*middle, 1 / MaximumFactor, MaximumFactor);
}

/// Fits the factors between the rates and the usual ones, by coordinate descent.
void ExtractionRate::Fit()
{
  const double speed = this->FindSpeed();
  std::vector<Terms> shares; // of the usual rates in each observation
  std::vector<double> errors;
  for (const Observation& seen : this->Observations)
  {
    Terms share;
    for (std::size_t kind = 0; kind < share.size(); ++kind)
    {
      share[kind] = seen.Counts[kind] * UsualRates[kind] * speed;
    }
    const double usual = std::accumulate(share.begin(), share.end(), 0.0);
    // Relative to the larger one, so that no outlier outweighs the others.
    const double scale = 1 / (std::max(seen.Seconds, usual) + Tolerance);
    std::for_each(share.begin(), share.end(), [scale](double& term) { term *= scale; });
    shares.push_back(share);
    errors.push_back((seen.Seconds - usual) * scale);
  }
  Terms factors;
  factors.fill(1);
  for (int sweep = 0; sweep < Sweeps; ++sweep)
  {
    for (std::size_t kind = 0; kind < factors.size(); ++kind)
    {
      double slope = UsualWeight * (1 - factors[kind]);
      double curvature = UsualWeight;
      for (std::size_t n = 0; n < shares.size(); ++n)
      {
        slope += shares[n][kind] * errors[n];
        curvature += shares[n][kind] * shares[n][kind];
      }
      const double step = std::max(-factors[kind], slope / curvature);
      factors[kind] += step;
      for (std::size_t n = 0; n < shares.size(); ++n)
      {
        errors[n] -= shares[n][kind] * step;
      }
    }
  }
  for (std::size_t kind = 0; kind < factors.size(); ++kind)
  {
    this->Rates[kind] = UsualRates[kind] * speed * factors[kind];
  }
}

} // namespace isosurface
