// SPDX-License-Identifier: BSD-3-Clause
#include "Store/ExtractionRate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isosurface
{
namespace
{

/// One outlier, a disk that had fallen asleep, say, must not spoil the rates.
constexpr double LargestCorrection = 8;

} // namespace

ExtractionRate::Terms ExtractionRate::Count(const ExtractionWork& work)
{
  return { 1, work.Blocks, work.SampleBytes, work.ReadBytes, work.Triangles };
}

double ExtractionRate::Predict(const ExtractionWork& work) const
{
  const Terms counts = Count(work);
  double seconds = 0;
  for (std::size_t kind = 0; kind < counts.size(); ++kind)
  {
    seconds += counts[kind] * this->Rates[kind];
  }
  return seconds;
}

void ExtractionRate::Observe(const ExtractionWork& work, double seconds)
{
  const Terms counts = Count(work);
  const double predicted = this->Predict(work);
  const double ratio =
    std::clamp(std::max(seconds, 1e-6) / predicted, 1 / LargestCorrection, LargestCorrection);
  for (std::size_t kind = 0; kind < counts.size(); ++kind)
  {
    this->Rates[kind] *= std::pow(ratio, counts[kind] * this->Rates[kind] / predicted);
  }
  this->Known = true;
}

} // namespace isosurface
