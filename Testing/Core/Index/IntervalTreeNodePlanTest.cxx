// SPDX-License-Identifier: BSD-3-Clause
#include "Index/IntervalTreeNodePlan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

constexpr std::uint32_t RecordsPerPage = 40;

struct Case
{
  std::vector<ValueKey> Boundaries;
  std::vector<std::pair<ValueKey, ValueKey>> Intervals;
};

Case MakeCase(std::mt19937_64& random)
{
  Case one;
  ValueKey key = random() % 3;
  const std::size_t boundaries = 1 + random() % 27;
  for (std::size_t index = 0; index < boundaries; ++index)
  {
    one.Boundaries.push_back(key);
    key += 1 + random() % 5;
  }
  const std::size_t count = random() % 4000;
  const ValueKey length = 1 + random() % (key + 3);
  for (std::size_t index = 0; index < count; ++index)
  {
    const ValueKey minimum = random() % (key + 3);
    one.Intervals.emplace_back(minimum, minimum + random() % length);
  }
  return one;
}

/// Whether the interval contains all of slab (b[slab - 1], b[slab]] and begins before it.
bool Spans(const Case& one, const std::pair<ValueKey, ValueKey>& interval, std::size_t slab)
{
  return slab > 0 && slab < one.Boundaries.size() && interval.first <= one.Boundaries[slab - 1] &&
    interval.second >= one.Boundaries[slab];
}

} // namespace

TEST(IntervalTreeNodePlan, GroupsHoldWhatSpansTheirSlabsWithinTheBounds)
{
  std::mt19937_64 random(4);
  for (int round = 0; round < 300; ++round)
  {
    const Case one = MakeCase(random);
    const std::size_t limit = random() % 2 ? 400 : 3;
    IntervalTreeNodePlan plan(one.Boundaries);
    for (const auto& interval : one.Intervals)
    {
      plan.Count(plan.Place(interval.first, interval.second));
    }
    plan.Decide(RecordsPerPage, limit);
    const auto& groups = plan.GetGroups();
    const std::size_t multislabs = plan.GetMultislabCount();
    ASSERT_LE(multislabs, limit);

    std::vector<std::uint32_t> listed(groups.size(), 0);
    std::vector<std::uint32_t> spanning(plan.GetSlabCount(), 0); // in the underflow list
    std::uint64_t underflow = 0;
    std::map<std::size_t, std::uint32_t> left, right, children;
    for (const auto& interval : one.Intervals)
    {
      const auto placement = plan.Place(interval.first, interval.second);
      const bool holdsBoundary = std::any_of(one.Boundaries.begin(), one.Boundaries.end(),
        [&](ValueKey b) { return interval.first <= b && b <= interval.second; });
      ASSERT_EQ(placement.IsInChild(), !holdsBoundary);
      if (!holdsBoundary)
      {
        ++children[placement.First];
        continue;
      }
      ++left[placement.First];
      if (placement.EndsInside)
      {
        ++right[placement.End];
      }
      std::vector<std::size_t> spanned;
      for (std::size_t slab = 0; slab < plan.GetSlabCount(); ++slab)
      {
        if (Spans(one, interval, slab))
        {
          spanned.push_back(slab);
        }
      }
      ASSERT_EQ(placement.IsMultislab(), !spanned.empty());
      if (spanned.empty())
      {
        continue;
      }
      const auto range = plan.FindGroups(placement);
      ASSERT_LT(range.First, range.End);
      for (std::uint32_t group = range.First; group < range.End; ++group)
      {
        ++listed[group];
      }
      if (range.First < multislabs)
      {
        ASSERT_EQ(groups[range.First].First, spanned.front());
        ASSERT_EQ(groups[range.First].Last, spanned.back());
        continue;
      }
      ++underflow;
      for (const std::size_t slab : spanned)
      {
        ++spanning[slab];
        const auto window = static_cast<std::uint32_t>(plan.GetWindow(slab));
        ASSERT_TRUE(range.First <= window && window < range.End);
      }
    }

    std::uint64_t inWindows = 0;
    for (std::size_t group = 0; group < groups.size(); ++group)
    {
      ASSERT_EQ(groups[group].Count, listed[group]);
      if (group < multislabs)
      {
        ASSERT_GE(groups[group].Count, RecordsPerPage / 2);
        continue;
      }
      inWindows += groups[group].Count;
      for (std::size_t slab = groups[group].First; slab <= groups[group].Last; ++slab)
      {
        ASSERT_EQ(plan.GetWindow(slab), static_cast<int>(group));
        ASSERT_LE(groups[group].Count, std::max(RecordsPerPage, 2 * spanning[slab]));
      }
    }
    ASSERT_LE(inWindows, 5 * underflow);
    for (std::size_t slab = 0; slab < plan.GetSlabCount(); ++slab)
    {
      ASSERT_EQ(plan.GetWindow(slab) >= 0, spanning[slab] > 0);
      ASSERT_EQ(plan.GetLeftCount(slab), left[slab]);
      ASSERT_EQ(plan.GetRightCount(slab), right[slab]);
      ASSERT_EQ(plan.GetChildCount(slab), children[slab]);
    }
  }
}
