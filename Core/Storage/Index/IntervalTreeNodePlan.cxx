// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalTreeNodePlan.h"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

namespace isosurface
{

IntervalTreeNodePlan::IntervalTreeNodePlan(std::vector<ValueKey> boundaries)
  : Boundaries(std::move(boundaries))
  , Children(this->GetSlabCount())
  , Left(this->GetSlabCount())
  , Right(this->GetSlabCount())
  , Spans(this->GetSlabCount() * this->GetSlabCount())
  , GroupOfSpan(this->GetSlabCount() * this->GetSlabCount(), -1)
  , WindowOfSlab(this->GetSlabCount(), -1)
{
}

IntervalTreeNodePlan::Placement IntervalTreeNodePlan::Place(
  ValueKey minimum, ValueKey maximum) const
{
  const auto begin = this->Boundaries.begin();
  const auto end = this->Boundaries.end();
  const auto first = std::lower_bound(begin, end, minimum);
  const auto last = std::upper_bound(first, end, maximum);
  Placement placement;
  placement.First = static_cast<std::uint16_t>(first - begin);
  placement.End = static_cast<std::uint16_t>(last - begin);
  placement.EndsInside = last != begin && *(last - 1) < maximum;
  return placement;
}

void IntervalTreeNodePlan::Count(const Placement& placement)
{
  if (placement.IsInChild())
  {
    ++this->Children[placement.First];
    return;
  }
  ++this->Left[placement.First];
  if (placement.EndsInside)
  {
    ++this->Right[placement.End];
  }
  if (placement.IsMultislab())
  {
    ++this->Spans[(placement.First + 1u) * this->GetSlabCount() + placement.End - 1u];
  }
}

void IntervalTreeNodePlan::Decide(std::uint32_t recordsPerPage, std::size_t multislabLimit)
{
  this->DecideMultislabs(recordsPerPage, multislabLimit);
  this->DecideWindows(recordsPerPage);
}

IntervalTreeNodePlan::GroupRange IntervalTreeNodePlan::FindGroups(const Placement& placement) const
{
  const std::size_t first = placement.First + 1u;
  const std::size_t last = placement.End - 1u;
  const std::int32_t own = this->GroupOfSpan[first * this->GetSlabCount() + last];
  if (own >= 0)
  {
    return { static_cast<std::uint32_t>(own), static_cast<std::uint32_t>(own) + 1 };
  }
  // Every slab that an interval of the underflow list spans has a window.
  assert(this->WindowOfSlab[first] >= 0 && this->WindowOfSlab[last] >= 0);
  return { static_cast<std::uint32_t>(this->WindowOfSlab[first]),
    static_cast<std::uint32_t>(this->WindowOfSlab[last]) + 1 };
}

void IntervalTreeNodePlan::DecideMultislabs(
  std::uint32_t recordsPerPage, std::size_t multislabLimit)
{
  const std::size_t slabs = this->GetSlabCount();
  for (std::size_t first = 0; first < slabs; ++first)
  {
    for (std::size_t last = first; last < slabs; ++last)
    {
      const std::uint32_t count = this->Spans[first * slabs + last];
      if (count > 0 && count >= recordsPerPage / 2)
      {
        this->Groups.push_back(
          { static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(last), count });
      }
    }
  }
  // If not all fit, the longest lists are kept.
  std::stable_sort(this->Groups.begin(), this->Groups.end(),
    [](const Group& a, const Group& b) { return a.Count > b.Count; });
  this->Groups.resize(std::min(this->Groups.size(), multislabLimit));
  std::sort(this->Groups.begin(), this->Groups.end(),
    [](const Group& a, const Group& b)
    { return std::tie(a.First, a.Last) < std::tie(b.First, b.Last); });
  this->MultislabCount = this->Groups.size();
  for (std::size_t group = 0; group < this->Groups.size(); ++group)
  {
    const std::size_t span = this->Groups[group].First * slabs + this->Groups[group].Last;
    this->GroupOfSpan[span] = static_cast<std::int32_t>(group);
    this->Spans[span] = 0; // the remaining ones are the underflow list
  }
}

void IntervalTreeNodePlan::DecideWindows(std::uint32_t recordsPerPage)
{
  const std::size_t slabs = this->GetSlabCount();
  bool open = false;
  std::uint64_t minimum = 0; // of the numbers of intervals that span a slab of the open window
  for (std::size_t slab = 0; slab < slabs; ++slab)
  {
    std::uint64_t spanning = 0;  // intervals that span this slab
    std::uint64_t beginning = 0; // those that do not span the previous slab
    for (std::size_t last = slab; last < slabs; ++last)
    {
      beginning += this->Spans[slab * slabs + last];
      for (std::size_t first = 0; first <= slab; ++first)
      {
        spanning += this->Spans[first * slabs + last];
      }
    }
    if (spanning == 0)
    {
      open = false;
      continue;
    }
    minimum = open ? std::min(minimum, spanning) : spanning;
    if (open &&
      this->Groups.back().Count + beginning > std::max<std::uint64_t>(recordsPerPage, 2 * minimum))
    {
      open = false;
    }
    if (open)
    {
      this->Groups.back().Last = static_cast<std::uint16_t>(slab);
      this->Groups.back().Count += static_cast<std::uint32_t>(beginning);
    }
    else
    {
      this->Groups.push_back({ static_cast<std::uint16_t>(slab), static_cast<std::uint16_t>(slab),
        static_cast<std::uint32_t>(spanning) });
      minimum = spanning;
      open = true;
    }
    this->WindowOfSlab[slab] = static_cast<std::int32_t>(this->Groups.size() - 1);
  }
}

} // namespace isosurface
