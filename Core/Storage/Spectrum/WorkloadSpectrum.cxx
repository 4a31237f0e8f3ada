// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

/// floor(value / 2^exponent). Its magnitude must be below 2^63.
template <typename T>
std::int64_t FloorQuotient(T value, int exponent)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    const double quotient = std::floor(std::ldexp(static_cast<double>(value), -exponent));
    // A small negative quotient may have underflowed to zero.
    return value < 0 && quotient > -1 ? -1 : static_cast<std::int64_t>(quotient);
  }
  else
  {
    return static_cast<std::int64_t>(value >> exponent);
  }
}

/// The exponent of the minimum width of bins for values of a range.
template <typename T>
int FindFinestExponent(T minimum, T maximum)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    using Limits = std::numeric_limits<T>;
    const T magnitude = std::max(std::abs(minimum), std::abs(maximum));
    const int spacing = magnitude == 0
      ? 0
      : std::max(std::ilogb(magnitude), Limits::min_exponent - 1) - Limits::digits + 1;
    // Halved, since the difference of two doubles may overflow.
    const double half = 0.5 * static_cast<double>(maximum) - 0.5 * static_cast<double>(minimum);
    return half > 0 ? std::max(spacing, std::ilogb(half) + 1 - 11) : spacing;
  }
  else
  {
    return static_cast<std::uint64_t>(maximum) > std::uint64_t{ 1 } << 63 && std::is_unsigned_v<T>
      ? 1
      : 0;
  }
}

template <typename T>
SpectrumBins ChooseBins(T minimum, T maximum)
{
  SpectrumBins bins;
  bins.Exponent = FindFinestExponent(minimum, maximum);
  for (;; ++bins.Exponent)
  {
    bins.First = FloorQuotient(minimum, bins.Exponent);
    const auto last = static_cast<std::uint64_t>(FloorQuotient(maximum, bins.Exponent));
    const std::uint64_t steps = last - static_cast<std::uint64_t>(bins.First);
    if (steps < SpectrumBins::MaximumCount)
    {
      bins.Count = static_cast<std::uint32_t>(steps + 1);
      return bins;
    }
  }
}

} // namespace

SpectrumBins SpectrumBins::Choose(ValueType type, const KeyRange& finiteRange)
{
  if (finiteRange.IsEmpty())
  {
    return {};
  }
  return DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      return ChooseBins(
        MakeValueOfKey<T>(finiteRange.Minimum), MakeValueOfKey<T>(finiteRange.Maximum));
    });
}

double SpectrumBins::GetEdge(std::size_t bin) const
{
  const auto multiple = this->First + static_cast<std::int64_t>(bin);
  return std::ldexp(static_cast<double>(multiple), this->Exponent);
}

std::vector<double> SpectrumBins::GetEdges() const
{
  std::vector<double> edges;
  for (std::size_t bin = 0; bin < this->Count; ++bin)
  {
    edges.push_back(this->GetEdge(bin));
  }
  return edges;
}

ValueKey SpectrumBins::GetEdgeKey(ValueType type, std::size_t bin) const
{
  return DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>)
      {
        return MakeValueKey(*FindThreshold<T>(this->GetEdge(bin)));
      }
      else
      {
        const auto multiple = static_cast<std::uint64_t>(this->First) + bin;
        return MakeValueKey(static_cast<T>(multiple << this->Exponent));
      }
    });
}

WorkloadSpectrum::WorkloadSpectrum(const SpectrumBins& bins)
  : Bins(bins)
{
  for (Counts* counts : this->GetQuantities())
  {
    counts->assign(bins.Count, 0);
  }
}

std::array<WorkloadSpectrum::Counts*, WorkloadSpectrum::NumberOfQuantities>
WorkloadSpectrum::GetQuantities()
{
  return std::array{ &this->Triangles, &this->ActiveCells, &this->ActiveBlocks, &this->Bytes,
    &this->Area, &this->Volume };
}

std::array<const WorkloadSpectrum::Counts*, WorkloadSpectrum::NumberOfQuantities>
WorkloadSpectrum::GetQuantities() const
{
  return std::array{ &this->Triangles, &this->ActiveCells, &this->ActiveBlocks, &this->Bytes,
    &this->Area, &this->Volume };
}

std::vector<double> WorkloadSpectrum::Scale(const Counts& quantity) const
{
  const double unit = &quantity == &this->Area ? this->AreaUnit
    : &quantity == &this->Volume               ? this->VolumeUnit
                                               : 1;
  std::vector<double> scaled;
  for (const std::uint64_t count : quantity)
  {
    scaled.push_back(static_cast<double>(count) * unit);
  }
  return scaled;
}

std::size_t WorkloadSpectrum::FindBin(double isovalue) const
{
  std::size_t low = 0;
  std::size_t high = this->Bins.Count;
  while (low + 1 < high)
  {
    const std::size_t middle = low + (high - low) / 2;
    (this->Bins.GetEdge(middle) <= isovalue ? low : high) = middle;
  }
  return low;
}

bool WorkloadSpectrum::Add(const WorkloadSpectrum& other)
{
  const bool hasUnits = this->AreaUnit != 0 || this->VolumeUnit != 0;
  if (this->Bins != other.Bins ||
    (hasUnits && (this->AreaUnit != other.AreaUnit || this->VolumeUnit != other.VolumeUnit)))
  {
    return false;
  }
  this->AreaUnit = other.AreaUnit;
  this->VolumeUnit = other.VolumeUnit;
  const auto mine = this->GetQuantities();
  const auto others = other.GetQuantities();
  for (std::size_t quantity = 0; quantity < NumberOfQuantities; ++quantity)
  {
    mine[quantity]->resize(std::min(mine[quantity]->size(), others[quantity]->size()));
    for (std::size_t bin = 0; bin < mine[quantity]->size(); ++bin)
    {
      (*mine[quantity])[bin] += (*others[quantity])[bin];
    }
  }
  return true;
}

} // namespace isosurface
