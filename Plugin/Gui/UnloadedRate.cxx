// SPDX-License-Identifier: BSD-3-Clause
#include "UnloadedRate.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace isosurface
{
namespace
{

/// Extractions remembered: enough that all of them are rarely slowed down.
constexpr std::size_t Memory = 6;

/// How many times the time of the fastest one an extraction may count.
constexpr double Tolerance = 2;

/// Less time than this is the clock's and the pipeline's as much as the extraction's.
constexpr double ShortestSeconds = 5e-3;

/// How much longer than on a usual laptop an extraction took.
double CompareToUsual(const ExtractionWork& work, double seconds)
{
  return (seconds + ShortestSeconds) / (ExtractionRate().Predict(work) + ShortestSeconds);
}

} // namespace

double UnloadedRate::FindSlowness() const
{
  double slowness =
    this->Observations.size() < Memory ? 1.0 : std::numeric_limits<double>::infinity();
  for (const Observation& seen : this->Observations)
  {
    slowness = std::min(slowness, CompareToUsual(seen.Work, seen.Seconds));
  }
  return slowness;
}

void UnloadedRate::Observe(const ExtractionWork& work, double seconds)
{
  if (this->Observations.size() == Memory)
  {
    this->Observations.erase(this->Observations.begin());
  }
  this->Observations.push_back({ work, seconds });
  const double limit = Tolerance * this->FindSlowness();
  this->Rate = ExtractionRate();
  for (const Observation& seen : this->Observations)
  {
    const double usual = ExtractionRate().Predict(seen.Work) + ShortestSeconds;
    this->Rate.Observe(seen.Work, std::min(seen.Seconds, limit * usual));
  }
}

} // namespace isosurface
