// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/TupleRanges.h"

#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <type_traits>

namespace isosurface
{
namespace
{

/// So many tuples at a time have lanes of their own, which a compiler takes in one register.
constexpr std::size_t TuplesAtOnce = 16;
constexpr std::size_t TuplesOfTask = std::size_t{ 1 } << 16;

/// What is known of the values that a lane has got so far.
template <typename T>
struct Lanes
{
  std::vector<T> Minima;
  std::vector<T> Maxima;
  std::vector<T> Zeros; ///< sums of zeros, unless a value is not finite

  explicit Lanes(std::size_t count)
    : Minima(count, std::numeric_limits<T>::max())
    , Maxima(count, std::numeric_limits<T>::lowest())
    , Zeros(count, T{ 0 })
  {
  }

  /// Adds a value to each of the first `count` lanes.
  void Add(const T* values, std::size_t count)
  {
    T* const minima = this->Minima.data();
    T* const maxima = this->Maxima.data();
    T* const zeros = this->Zeros.data();
    for (std::size_t lane = 0; lane < count; ++lane)
    {
      const T value = values[lane];
      minima[lane] = value < minima[lane] ? value : minima[lane];
      maxima[lane] = value > maxima[lane] ? value : maxima[lane];
      if constexpr (std::is_floating_point_v<T>)
      {
        zeros[lane] += value * 0;
      }
    }
  }
};

/// The squared norms of up to TuplesAtOnce tuples.
template <typename T>
void ComputeSquaredNorms(
  const T* values, std::size_t tuples, std::size_t components, double* squaredNorms)
{
  for (std::size_t tuple = 0; tuple < tuples; ++tuple)
  {
    double sum = 0;
    for (std::size_t component = 0; component < components; ++component)
    {
      const auto value = static_cast<double>(values[tuple * components + component]);
      sum += value * value;
    }
    squaredNorms[tuple] = sum;
  }
}

template <typename T>
TupleRanges<T> FindRanges(const T* values, std::size_t tuples, std::size_t components)
{
  Lanes<T> lanes(TuplesAtOnce * components);
  Lanes<double> norms(TuplesAtOnce);
  double squaredNorms[TuplesAtOnce];
  for (std::size_t first = 0; first < tuples; first += TuplesAtOnce)
  {
    const std::size_t count = std::min(TuplesAtOnce, tuples - first);
    const T* some = values + first * components;
    lanes.Add(some, count * components);
    if (components == 3 && count == TuplesAtOnce)
    {
      ComputeSquaredNorms(some, TuplesAtOnce, 3, squaredNorms); // numbers that a compiler knows
    }
    else if (components > 1)
    {
      ComputeSquaredNorms(some, count, components, squaredNorms);
    }
    if (components > 1)
    {
      norms.Add(squaredNorms, count);
    }
  }

  TupleRanges<T> ranges;
  ranges.Components.resize(components);
  for (std::size_t lane = 0; lane < lanes.Minima.size(); ++lane)
  {
    ranges.Components[lane % components].Add({ lanes.Minima[lane], lanes.Maxima[lane] });
    ranges.AreFinite = ranges.AreFinite && lanes.Zeros[lane] == 0;
  }
  for (std::size_t lane = 0; lane < TuplesAtOnce; ++lane)
  {
    ranges.SquaredNorm.Add({ norms.Minima[lane], norms.Maxima[lane] });
  }
  return ranges;
}

} // namespace

template <typename T>
TupleRanges<T> FindTupleRanges(
  const T* values, std::size_t tuples, std::size_t components, int threads)
{
  TupleRanges<T> all;
  all.Components.resize(components);
  std::vector<TupleRanges<T>> parts((tuples + TuplesOfTask - 1) / TuplesOfTask);
  ParallelFor(parts.size(), threads,
    [&](std::size_t part, int)
    {
      const std::size_t first = part * TuplesOfTask;
      parts[part] =
        FindRanges(values + first * components, std::min(TuplesOfTask, tuples - first), components);
    });
  for (const TupleRanges<T>& part : parts)
  {
    for (std::size_t component = 0; component < components; ++component)
    {
      all.Components[component].Add(part.Components[component]);
    }
    all.SquaredNorm.Add(part.SquaredNorm);
    all.AreFinite = all.AreFinite && part.AreFinite;
  }
  return all;
}

template TupleRanges<float> FindTupleRanges(const float*, std::size_t, std::size_t, int);
template TupleRanges<double> FindTupleRanges(const double*, std::size_t, std::size_t, int);
template TupleRanges<long> FindTupleRanges(const long*, std::size_t, std::size_t, int);
template TupleRanges<long long> FindTupleRanges(const long long*, std::size_t, std::size_t, int);

} // namespace isosurface
