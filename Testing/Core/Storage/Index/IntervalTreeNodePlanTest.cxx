// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalTreeNodePlan.h"

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

/// Counts again, from the definitions, what a plan of the case's intervals says.
class PlanCheck
{
public:
  PlanCheck(const Case& one, std::size_t multislabLimit)
    : One(one)
    , Plan(one.Boundaries)
  {
    for (const auto& interval : one.Intervals)
    {
      this->Plan.Count(this->Plan.Place(interval.first, interval.second));
    }
    this->Plan.Decide(RecordsPerPage, multislabLimit);
    this->Listed.resize(this->Plan.GetGroups().size());
    this->Spanning.resize(this->Plan.GetSlabCount());
  }

  void CheckPlacements()
  {
    for (const auto& interval : this->One.Intervals)
    {
      const auto placement = this->Plan.Place(interval.first, interval.second);
      const bool holdsBoundary =
        std::any_of(this->One.Boundaries.begin(), this->One.Boundaries.end(),
          [&](ValueKey b) { return interval.first <= b && b <= interval.second; });
      ASSERT_EQ(placement.IsInChild(), !holdsBoundary);
      if (!holdsBoundary)
      {
        ++this->Children[placement.First];
        continue;
      }
      ++this->Left[placement.First];
      if (placement.EndsInside)
      {
        ++this->Right[placement.End];
      }
      ASSERT_NO_FATAL_FAILURE(this->CheckSpans(placement, this->FindSpanned(interval)));
    }
  }

  void CheckGroups() const
  {
    const auto& groups = this->Plan.GetGroups();
    std::uint64_t inWindows = 0;
    for (std::size_t group = 0; group < groups.size(); ++group)
    {
      ASSERT_EQ(groups[group].Count, this->Listed[group]);
      if (group < this->Plan.GetMultislabCount())
      {
        ASSERT_GE(groups[group].Count, RecordsPerPage / 2);
        continue;
      }
      inWindows += groups[group].Count;
      for (std::size_t slab = groups[group].First; slab <= groups[group].Last; ++slab)
      {
        ASSERT_EQ(this->Plan.GetWindow(slab), static_cast<int>(group));
        ASSERT_LE(groups[group].Count, std::max(RecordsPerPage, 2 * this->Spanning[slab]));
      }
    }
    ASSERT_LE(inWindows, 4 * this->Underflow);
  }

  void CheckSlabs()
  {
    for (std::size_t slab = 0; slab < this->Plan.GetSlabCount(); ++slab)
    {
      ASSERT_EQ(this->Plan.GetWindow(slab) >= 0, this->Spanning[slab] > 0);
      ASSERT_EQ(this->Plan.GetLeftCount(slab), this->Left[slab]);
      ASSERT_EQ(this->Plan.GetRightCount(slab), this->Right[slab]);
      ASSERT_EQ(this->Plan.GetChildCount(slab), this->Children[slab]);
    }
  }

  std::size_t GetMultislabCount() const { return this->Plan.GetMultislabCount(); }

private:
  /// The slabs (b[slab - 1], b[slab]] that an interval contains and that do not contain its
  /// minimum.
  std::vector<std::size_t> FindSpanned(const std::pair<ValueKey, ValueKey>& interval) const
  {
    std::vector<std::size_t> spanned;
    for (std::size_t slab = 1; slab < this->One.Boundaries.size(); ++slab)
    {
      if (interval.first <= this->One.Boundaries[slab - 1] &&
        interval.second >= this->One.Boundaries[slab])
      {
        spanned.push_back(slab);
      }
    }
    return spanned;
  }

  void CheckSpans(
    const IntervalTreeNodePlan::Placement& placement, const std::vector<std::size_t>& spanned)
  {
    ASSERT_EQ(placement.IsMultislab(), !spanned.empty());
    if (spanned.empty())
    {
      return;
    }
    const auto range = this->Plan.FindGroups(placement);
    ASSERT_LT(range.First, range.End);
    for (std::uint32_t group = range.First; group < range.End; ++group)
    {
      ++this->Listed[group];
    }
    if (range.First < this->Plan.GetMultislabCount())
    {
      ASSERT_EQ(this->Plan.GetGroups()[range.First].First, spanned.front());
      ASSERT_EQ(this->Plan.GetGroups()[range.First].Last, spanned.back());
      return;
    }
    ++this->Underflow;
    for (const std::size_t slab : spanned)
    {
      ++this->Spanning[slab];
      const auto window = static_cast<std::uint32_t>(this->Plan.GetWindow(slab));
      ASSERT_TRUE(range.First <= window && window < range.End);
    }
  }

  const Case& One;
  IntervalTreeNodePlan Plan;
  std::vector<std::uint32_t> Listed;   // by group
  std::vector<std::uint32_t> Spanning; // underflow intervals, by slab
  std::uint64_t Underflow = 0;
  std::map<std::size_t, std::uint32_t> Left, Right, Children; // by slab
};

} // namespace

TEST(IntervalTreeNodePlan, CountsAndListsKeepTheirDefinitionsAndBounds)
{
  std::mt19937_64 random(4);
  for (int round = 0; round < 300; ++round)
  {
    const Case one = MakeCase(random);
    const std::size_t limit = random() % 2 ? 400 : 3;
    PlanCheck check(one, limit);
    ASSERT_LE(check.GetMultislabCount(), limit);
    ASSERT_NO_FATAL_FAILURE(check.CheckPlacements());
    ASSERT_NO_FATAL_FAILURE(check.CheckGroups());
    ASSERT_NO_FATAL_FAILURE(check.CheckSlabs());
  }
}
