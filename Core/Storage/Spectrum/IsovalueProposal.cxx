// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/IsovalueProposal.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace isosurface
{
namespace
{

/// The multiple of a power of ten, at most `coarsest`, that is nearest to a value; the value itself if there
/// is no such number in (low, high].
double Round(double value, double coarsest, double low, double high)
{
  if (coarsest < std::numeric_limits<double>::min()) // has no exponent of ten
  {
    return value;
  }
  const int exponent = static_cast<int>(std::floor(std::log10(coarsest)));
  // Powers of ten below 1 are not exact; their reciprocals are.
  const double scale = std::pow(10.0, std::abs(exponent));
  const double rounded =
    exponent < 0 ? std::round(value * scale) / scale : std::round(value / scale) * scale;
  return rounded > low && rounded <= high ? rounded : value;
}

} // namespace

std::optional<double> ProposeIsovalue(
  const std::vector<double>& values, const std::vector<double>& counts)
{
  std::vector<std::size_t> occupied;
  for (std::size_t bin = 0; bin < values.size(); ++bin)
  {
    if (counts[bin] > 0)
    {
      occupied.push_back(bin);
    }
  }
  if (occupied.size() < 2)
  {
    return std::nullopt;
  }
  const double first = values[occupied.front()];
  const double range = values[occupied.back()] - first;
  // Of places within the range, so that neither large nor small numbers cost digits.
  double total = 0;
  double sum = 0;
  for (const std::size_t bin : occupied)
  {
    total += counts[bin];
    sum += counts[bin] * ((values[bin] - first) / range);
  }
  double best = -1;
  double apart = 0; // the means of the classes
  double below = first;
  double above = first;
  double countBelow = 0;
  double sumBelow = 0;
  for (std::size_t place = 0; place + 1 < occupied.size(); ++place)
  {
    const std::size_t bin = occupied[place];
    countBelow += counts[bin];
    sumBelow += counts[bin] * ((values[bin] - first) / range);
    const double countAbove = total - countBelow;
    const double difference = (sum - sumBelow) / countAbove - sumBelow / countBelow;
    const double between = countBelow * countAbove * difference * difference;
    if (between > best)
    {
      best = between;
      apart = difference * range;
      below = values[bin];
      above = values[occupied[place + 1]];
    }
  }
  const double isovalue = below + (above - below) / 2;
  constexpr double steps = 50;
  return std::isfinite(apart) && apart > 0 ? Round(isovalue, apart / steps, first, first + range)
                                           : isovalue;
}

std::optional<double> ProposeIsovalue(const WorkloadSpectrum& spectrum)
{
  const WorkloadSpectrum::Counts& volume = spectrum.Volume;
  if (volume.empty())
  {
    return std::nullopt;
  }
  std::vector<double> counts;
  for (std::size_t bin = 0; bin < volume.size(); ++bin)
  {
    // Volumes are estimates, which may grow a little.
    const std::uint64_t next = bin + 1 < volume.size() ? volume[bin + 1] : 0;
    counts.push_back(volume[bin] > next ? static_cast<double>(volume[bin] - next) : 0.0);
  }
  return ProposeIsovalue(spectrum.Bins.GetEdges(), counts);
}

} // namespace isosurface
