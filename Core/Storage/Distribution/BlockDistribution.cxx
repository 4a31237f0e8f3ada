// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Distribution/BlockDistribution.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/EnumeratorNames.h"
#include "Storage/Distribution/BlockBalancer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>

namespace isosurface
{
namespace
{

/// What Greedy looks at: the element of the matrix and the size of a block's range.
struct Span
{
  std::uint32_t Element; ///< of the matrix, row by row; after the last one for a constant block
  std::uint32_t Block;
  double Size;
};

/// The element and size of each block's range. Infinite ends are clamped.
std::vector<Span> MakeSpans(ValueType type, const std::vector<KeyRange>& ranges)
{
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::vector<std::array<double, 2>> ends(ranges.size());
  for (std::size_t block = 0; block < ranges.size(); ++block)
  {
    if (ranges[block].IsEmpty())
    {
      continue;
    }
    ends[block] = ranges[block].GetValues(type);
    for (const double end : ends[block])
    {
      if (std::isfinite(end))
      {
        low = std::min(low, end);
        high = std::max(high, end);
      }
    }
  }
  // NaN counts as the minimum, since it is below every isovalue. Halved, since a difference of
  // doubles may overflow.
  const auto place = [&](double end)
  { return 0.5 * (std::isnan(end) ? low : std::clamp(end, low, high)) - 0.5 * low; };
  const double extent = low < high ? place(high) : 1;
  const auto find = [&](double offset)
  {
    const double element = std::floor(offset / extent * GreedyElements);
    return static_cast<std::uint32_t>(std::min<double>(element, GreedyElements - 1));
  };
  std::vector<Span> spans(ranges.size());
  for (std::size_t block = 0; block < ranges.size(); ++block)
  {
    Span& span = spans[block];
    span = { GreedyElements * GreedyElements, static_cast<std::uint32_t>(block), 0 };
    if (low <= high && ranges[block].Minimum < ranges[block].Maximum)
    {
      const double begin = place(ends[block][0]);
      span.Size = place(ends[block][1]) - begin;
      span.Element = find(begin) * GreedyElements + find(span.Size);
    }
  }
  return spans;
}

std::vector<std::uint32_t> Deal(std::vector<Span> spans, std::uint32_t stores)
{
  std::sort(spans.begin(), spans.end(),
    [](const Span& a, const Span& b)
    {
      return std::make_tuple(a.Element, -a.Size, a.Block) <
        std::make_tuple(b.Element, -b.Size, b.Block);
    });
  std::vector<std::uint32_t> result(spans.size());
  std::uint32_t store = 0;
  for (const Span& span : spans)
  {
    result[span.Block] = store;
    store = store + 1 == stores ? 0 : store + 1;
  }
  return result;
}

} // namespace

const char* GetDistributionName(DistributionMethod method)
{
  switch (method)
  {
    case DistributionMethod::Greedy:
      return "greedy";
    case DistributionMethod::Random:
      return "random";
    case DistributionMethod::Slab:
      return "slab";
    case DistributionMethod::Balanced:
      return "balanced";
  }
  return nullptr;
}

std::optional<DistributionMethod> FindDistribution(const std::string& name)
{
  return FindEnumerator(name, GetDistributionName);
}

std::vector<std::uint32_t> DistributeBlocks(DistributionMethod method, ValueType type,
  const std::vector<KeyRange>& ranges, std::uint32_t stores, std::uint64_t seed,
  const std::vector<BlockProfile>& profiles)
{
  assert(stores >= 1 && ranges.size() <= std::numeric_limits<std::uint32_t>::max());
  std::vector<std::uint32_t> result(ranges.size());
  switch (method)
  {
    case DistributionMethod::Greedy:
      return Deal(MakeSpans(type, ranges), stores);
    case DistributionMethod::Balanced:
      assert(profiles.size() == ranges.size());
      return BlockBalancer(profiles, stores).Distribute();
    case DistributionMethod::Random:
      for (std::uint64_t block = 0; block < result.size(); ++block)
      {
        result[block] =
          static_cast<std::uint32_t>(ComputeChecksum(&block, sizeof(block), seed) % stores);
      }
      break;
    case DistributionMethod::Slab:
      for (std::uint64_t block = 0; block < result.size(); ++block)
      {
        result[block] = static_cast<std::uint32_t>(block * stores / result.size());
      }
      break;
  }
  return result;
}

} // namespace isosurface
