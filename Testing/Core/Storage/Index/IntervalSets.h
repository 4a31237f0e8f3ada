// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalSets_h
#define isosurface_IntervalSets_h

#include "Fixtures/MemoryDisk.h"
#include "Storage/Index/ExternalIntervalTree.h"
#include "Storage/Index/ExternalIntervalTreeBuilder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace isosurface
{

using IntervalVector = std::vector<KeyInterval>;
constexpr ValueKey MaximumKey = std::numeric_limits<ValueKey>::max();

/// Makes `count` intervals. The payload is the index.
struct IntervalSet
{
  std::string Name;
  std::function<KeyInterval(std::uint64_t index, std::uint64_t count, std::mt19937_64& random)>
    Make;

  IntervalVector MakeAll(std::uint64_t count) const
  {
    std::mt19937_64 random(20250101);
    IntervalVector intervals;
    for (std::uint64_t index = 0; index < count; ++index)
    {
      KeyInterval interval = this->Make(index, count, random);
      if (interval.Minimum > interval.Maximum)
      {
        std::swap(interval.Minimum, interval.Maximum);
      }
      interval.Payload = static_cast<std::uint32_t>(index);
      intervals.push_back(interval);
    }
    return intervals;
  }
};

/// Sets that are adversarial for one or another part of the tree.
inline std::vector<IntervalSet> MakeIntervalSets()
{
  using Random = std::mt19937_64;
  using Index = std::uint64_t;
  auto make = [](ValueKey a, ValueKey b) { return KeyInterval{ a, b, 0 }; };
  return {
    { "AnyToAny", [=](Index, Index, Random& r) { return make(r(), r()); } },
    { "Short",
      [=](Index, Index, Random& r)
      {
        const ValueKey a = r() >> 1;
        return make(a, a + (r() >> 16));
      } },
    { "Nested", [=](Index i, Index n, Random&) { return make(i, 2 * n + 5 - i); } },
    { "NestedAtExtremes", [=](Index i, Index, Random&) { return make(i, MaximumKey - i); } },
    { "Disjoint", [=](Index i, Index, Random&) { return make(10 * i, 10 * i + 8); } },
    { "Touching", [=](Index i, Index, Random&) { return make(10 * i, 10 * i + 10); } },
    { "Identical", [=](Index, Index, Random&) { return make(1000, 2000); } },
    { "Staircase", [=](Index i, Index, Random&) { return make(i, i + 1500); } },
    { "SteepStaircase", [=](Index i, Index n, Random&) { return make(i, i + n / 2); } },
    { "OneValue", [=](Index, Index, Random&) { return make(7, 7); } },
    { "OneValueZero", [=](Index, Index, Random&) { return make(0, 0); } },
    { "OneValueMaximum", [=](Index, Index, Random&) { return make(MaximumKey, MaximumKey); } },
    { "Constants", [=](Index i, Index, Random&) { return make(3 * i, 3 * i); } },
    { "ConstantsOfFewValues",
      [=](Index, Index, Random& r)
      {
        const ValueKey a = r() % 5;
        return make(a, a);
      } },
    { "Bytes", [=](Index, Index, Random& r) { return make(1 + r() % 256, 1 + r() % 256); } },
    { "MostlyBackground",
      [=](Index, Index, Random& r)
      { return r() % 10 ? make(1, 1 + r() % 3) : make(1 + r() % 60000, 1 + r() % 60000); } },
    { "OneMinimum", [=](Index, Index, Random& r) { return make(0, r()); } },
    { "OneMaximum", [=](Index, Index, Random& r) { return make(r(), MaximumKey); } },
    { "AllScales",
      [=](Index, Index, Random& r)
      {
        const ValueKey a = r() >> (r() % 64);
        return make(a, a + std::min(MaximumKey - a, r() >> (r() % 64)));
      } },
    // As many places as a node has slabs, and few intervals between any two of them.
    { "ThinMultislabs",
      [=](Index, Index, Random& r)
      { return make((r() % 29) * 1000000 + r() % 1000, (r() % 29) * 1000000 + r() % 1000); } },
    { "Everything",
      [=](Index i, Index, Random& r)
      {
        return i % 3 == 0 ? make(0, MaximumKey)
          : i % 3 == 1    ? make(r() % 1000, 1000 + r() % 1000)
                          : make(1u << 20, 1u << 20);
      } },
  };
}

/// A key to query: an endpoint, a neighbour of one, an extreme, or any key.
inline ValueKey MakeQueryKey(const IntervalVector& intervals, std::mt19937_64& random)
{
  const std::uint64_t choice = random() % 16;
  if (intervals.empty() || choice == 0)
  {
    return random() % 2 ? random() : (random() % 2 ? 0 : MaximumKey);
  }
  const KeyInterval& one = intervals[random() % intervals.size()];
  const KeyInterval& other = intervals[random() % intervals.size()];
  switch (choice % 6)
  {
    case 0:
      return one.Minimum;
    case 1:
      return one.Maximum;
    case 2:
      return one.Minimum - 1; // may wrap around, which is a valid key, too
    case 3:
      return one.Maximum + 1;
    case 4:
      return one.Minimum / 2 + other.Minimum / 2;
    default:
      return one.Minimum / 2 + one.Maximum / 2;
  }
}

constexpr std::size_t TestMemoryLimit = 16 * 1024 * 1024;

inline Status WriteTree(FileSystem& disk, const std::string& path, const IntervalVector& intervals,
  std::size_t memoryLimit = TestMemoryLimit, std::uint32_t pageSize = PagedFile::DefaultPageSize)
{
  ExternalIntervalTreeBuilder builder(disk, path, memoryLimit, pageSize);
  for (const KeyInterval& interval : intervals)
  {
    ISOSURFACE_RETURN_IF_ERROR(builder.Add(interval));
  }
  return builder.Finish();
}

/// Compares the answer to a query with every interval; returns what is wrong, or nothing.
inline std::string CompareWithBruteForce(const ExternalIntervalTree& tree,
  const IntervalVector& intervals, ValueKey low, ValueKey high, PageStatistics& statistics,
  std::uint64_t& found)
{
  std::vector<std::uint8_t> seen(intervals.size(), 0);
  std::string fault;
  found = 0;
  const auto visit = [&](const KeyInterval& interval)
  {
    ++found;
    if (interval.Payload >= intervals.size() ||
      interval.Minimum != intervals[interval.Payload].Minimum ||
      interval.Maximum != intervals[interval.Payload].Maximum)
    {
      fault = "an interval that was never added";
    }
    else if (seen[interval.Payload]++)
    {
      fault = "an interval reported twice";
    }
  };
  const Status status = low == high ? tree.FindStabbed(low, visit, statistics)
                                    : tree.FindOverlapping(low, high, visit, statistics);
  if (!status.IsOk())
  {
    return status.GetMessage();
  }
  for (std::size_t index = 0; index < intervals.size() && fault.empty(); ++index)
  {
    const bool overlaps = intervals[index].Minimum <= high && low <= intervals[index].Maximum;
    if (overlaps != (seen[index] == 1))
    {
      fault = overlaps ? "an interval is missing" : "an interval too many";
    }
  }
  return fault.empty() ? fault
                       : fault + " for [" + std::to_string(low) + ", " + std::to_string(high) + "]";
}

} // namespace isosurface

#endif
