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

template <typename T>
TupleRanges<T> FindRanges(const T* values, std::size_t tuples, std::size_t components)
{
  TupleRanges<T> ranges;
  const std::size_t lanes = TuplesAtOnce * components;
  std::vector<ValueSpan<T>> spans(lanes);
  const std::size_t count = tuples * components;
  std::size_t at = 0;
  for (; at + lanes <= count; at += lanes)
  {
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
      spans[lane].Add(values[at + lane]);
    }
  }
  for (std::size_t lane = 0; at < count; ++at, ++lane)
  {
    spans[lane].Add(values[at]);
  }
  ranges.Components.resize(components);
  for (std::size_t lane = 0; lane < lanes; ++lane)
  {
    ranges.Components[lane % components].Add(spans[lane]);
  }
  if constexpr (std::is_floating_point_v<T>)
  {
    // A sum of zeros, unless a value is not finite.
    T zeros[TuplesAtOnce] = {};
    for (at = 0; at < count; ++at)
    {
      zeros[at % TuplesAtOnce] += values[at] * 0;
    }
    ranges.AreFinite = std::all_of(zeros, zeros + TuplesAtOnce, [](T zero) { return zero == 0; });
  }
  for (std::size_t tuple = 0; components > 1 && tuple < tuples; ++tuple)
  {
    double sum = 0;
    for (std::size_t component = 0; component < components; ++component)
    {
      const auto value = static_cast<double>(values[tuple * components + component]);
      sum += value * value;
    }
    ranges.SquaredNorm.Add(sum);
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
