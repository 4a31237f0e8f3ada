// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalTreeVerification.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

using Intervals = std::vector<KeyInterval>;

bool IsBefore(const KeyInterval& a, const KeyInterval& b)
{
  return std::tie(a.Minimum, a.Maximum, a.Payload) < std::tie(b.Minimum, b.Maximum, b.Payload);
}

/// Whether two lists have the same intervals, in whatever order.
bool AreEqual(Intervals a, Intervals b)
{
  std::sort(a.begin(), a.end(), IsBefore);
  std::sort(b.begin(), b.end(), IsBefore);
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
    [](const KeyInterval& one, const KeyInterval& other)
    { return !IsBefore(one, other) && !IsBefore(other, one); });
}

class IntervalTreeVerification
{
public:
  IntervalTreeVerification(
    const PagedFileReader& file, const IntervalTreeHeader& header, PageStatistics& statistics)
    : File(file)
    , Header(header)
    , Statistics(statistics)
    , RecordsPerPage(IntervalTreeFormat::GetRecordsPerPage(file.GetPayloadSize()))
    , RecordsLeft(file.GetPageCount() * RecordsPerPage)
    , IsVisited(static_cast<std::size_t>(file.GetPageCount()), false)
  {
  }

  /// Corrupt, naming file, page and reason, at the first fault.
  Status Run()
  {
    this->Left.push_back({ this->Header.Root });
    while (!this->Left.empty())
    {
      const Place place = this->Left.back();
      this->Left.pop_back();
      if (place.Subtree.List.Count > 0)
      {
        ISOSURFACE_RETURN_IF_ERROR(
          place.Subtree.Height == 0 ? this->VisitLeaf(place) : this->VisitNode(place));
      }
    }
    if (this->Found != this->Header.Count)
    {
      return this->File.MakeCorrupt(0,
        "the tree leads to " + std::to_string(this->Found) + " intervals, not to " +
          std::to_string(this->Header.Count));
    }
    if (this->Minimum != this->Header.Minimum || this->Maximum != this->Header.Maximum)
    {
      return this->File.MakeCorrupt(0, "the bounds of the tree are not those of its intervals");
    }
    return Status::Ok();
  }

private:
  /// A subtree whose intervals have to lie strictly between two boundaries.
  struct Place
  {
    IntervalSubtree Subtree;
    bool HasLow = false;
    bool HasHigh = false;
    ValueKey Low = 0;
    ValueKey High = 0;
    bool Contains(const KeyInterval& interval) const
    {
      return (!this->HasLow || interval.Minimum > this->Low) &&
        (!this->HasHigh || interval.Maximum < this->High);
    }
  };

  /// The intervals of one node, and in which lists they have to be.
  struct Expected
  {
    std::vector<Intervals> Right; ///< by slab
    struct Span
    {
      std::size_t First;
      std::size_t Last;
      KeyInterval Interval;
    };
    std::vector<Span> Spans;
  };

  Status VisitLeaf(const Place& place)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto records, this->ReadList(place.Subtree.List));
    for (const KeyInterval& interval : records)
    {
      if (!place.Contains(interval))
      {
        return this->File.MakeCorrupt(
          place.Subtree.List.Page, "an interval of a leaf is beyond the slab of the leaf");
      }
      this->Count(interval);
    }
    return Status::Ok();
  }

  Status VisitNode(const Place& place)
  {
    const std::uint32_t page = place.Subtree.List.Page;
    if (this->IsVisited[page])
    {
      return this->File.MakeCorrupt(page, "the node is there twice");
    }
    this->IsVisited[page] = true;
    ISOSURFACE_ASSIGN_OR_RETURN(const auto payload, this->File.ReadPage(page, this->Statistics));
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto node, IntervalTreeNode::Decode(this->File, page, payload->data()));
    if (node.Height != place.Subtree.Height)
    {
      return this->File.MakeCorrupt(page, "the node has another height than its parent says");
    }
    const std::uint64_t before = this->Found;
    Expected expected;
    ISOSURFACE_RETURN_IF_ERROR(this->CheckLeft(place, node, expected));
    ISOSURFACE_RETURN_IF_ERROR(this->CheckRight(page, node, expected));
    ISOSURFACE_RETURN_IF_ERROR(this->CheckMultislabs(page, node, expected));
    ISOSURFACE_RETURN_IF_ERROR(this->CheckWindows(page, node, expected));
    return this->AddChildren(place, node, this->Found - before);
  }

  /// Each interval of the node is in one left list: that of the slab of its minimum.
  Status CheckLeft(const Place& place, const IntervalTreeNode& node, Expected& expected)
  {
    const std::uint32_t page = place.Subtree.List.Page;
    expected.Right.resize(node.Slabs.size());
    for (std::size_t slab = 0; slab < node.Slabs.size(); ++slab)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto records, this->ReadList(node.Slabs[slab].Left));
      if (!records.empty() && records.front().Minimum != node.Slabs[slab].LeftMinimum)
      {
        return this->File.MakeCorrupt(page, "the minimum of a left list is not that of the list");
      }
      ValueKey last = 0;
      for (const KeyInterval& interval : records)
      {
        const auto end = static_cast<std::size_t>(
          std::upper_bound(node.Boundaries.begin(), node.Boundaries.end(), interval.Maximum) -
          node.Boundaries.begin());
        if (interval.Minimum < last || node.FindSlab(interval.Minimum) != slab || end <= slab ||
          !place.Contains(interval))
        {
          return this->File.MakeCorrupt(page, "a left list has an interval in a wrong place");
        }
        last = interval.Minimum;
        this->Count(interval);
        if (interval.Maximum > node.Boundaries[end - 1])
        {
          expected.Right[end].push_back(interval);
        }
        if (slab + 1 < end)
        {
          expected.Spans.push_back({ slab + 1, end - 1, interval });
        }
      }
    }
    return Status::Ok();
  }

  Status CheckRight(std::uint32_t page, const IntervalTreeNode& node, Expected& expected)
  {
    for (std::size_t slab = 0; slab < node.Slabs.size(); ++slab)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto records, this->ReadList(node.Slabs[slab].Right));
      if (!records.empty() && records.front().Maximum != node.Slabs[slab].RightMaximum)
      {
        return this->File.MakeCorrupt(page, "the maximum of a right list is not that of the list");
      }
      const bool isSorted = std::is_sorted(records.begin(), records.end(),
        [](const KeyInterval& a, const KeyInterval& b) { return a.Maximum > b.Maximum; });
      if (!isSorted || !AreEqual(records, std::move(expected.Right[slab])))
      {
        return this->File.MakeCorrupt(
          page, "a right list does not have the intervals that end in its slab");
      }
    }
    return Status::Ok();
  }

  /// A multislab list has all intervals that span its slabs; these are not in windows.
  Status CheckMultislabs(std::uint32_t page, const IntervalTreeNode& node, Expected& expected)
  {
    for (const IntervalTreeMultislab& multislab : node.Multislabs)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto records, this->ReadList(multislab.List));
      const auto isOther = [&](const Expected::Span& span)
      { return span.First != multislab.First || span.Last != multislab.Last; };
      const auto own = std::partition(expected.Spans.begin(), expected.Spans.end(), isOther);
      Intervals wanted;
      for (auto span = own; span != expected.Spans.end(); ++span)
      {
        wanted.push_back(span->Interval);
      }
      expected.Spans.erase(own, expected.Spans.end());
      if (!AreEqual(records, std::move(wanted)))
      {
        return this->File.MakeCorrupt(
          page, "a multislab list does not have the intervals that span its slabs");
      }
    }
    return Status::Ok();
  }

  /// What spans a slab and is in no multislab list is in the slab's window.
  Status CheckWindows(std::uint32_t page, const IntervalTreeNode& node, const Expected& expected)
  {
    std::vector<Intervals> lists;
    for (const IntervalList& window : node.Windows)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto records, this->ReadList(window));
      lists.push_back(std::move(records));
    }
    for (std::size_t number = 0; number <= lists.size(); ++number)
    {
      // The slabs of the window; at last those that have none, which nothing may span.
      const bool isNone = number == lists.size();
      const auto isOf = [&](std::size_t slab)
      {
        return node.Slabs[slab].Window ==
          (isNone ? std::size_t{ IntervalTreeSlab::NoWindow } : number);
      };
      Intervals wanted;
      for (const Expected::Span& span : expected.Spans)
      {
        bool spansOne = false;
        for (std::size_t slab = span.First; slab <= span.Last && !spansOne; ++slab)
        {
          spansOne = isOf(slab);
        }
        if (spansOne)
        {
          wanted.push_back(span.Interval);
        }
      }
      if (!AreEqual(isNone ? Intervals() : std::move(lists[number]), std::move(wanted)))
      {
        return this->File.MakeCorrupt(
          page, "an underflow window does not have the intervals that span its slabs");
      }
    }
    return Status::Ok();
  }

  Status AddChildren(const Place& place, const IntervalTreeNode& node, std::uint64_t own)
  {
    std::uint64_t sum = own;
    for (std::size_t slab = 0; slab < node.Slabs.size(); ++slab)
    {
      Place child{ node.Slabs[slab].Child, place.HasLow, place.HasHigh, place.Low, place.High };
      if (slab > 0)
      {
        child.HasLow = true;
        child.Low = node.Boundaries[slab - 1];
      }
      if (slab < node.Boundaries.size())
      {
        child.HasHigh = true;
        child.High = node.Boundaries[slab];
      }
      sum += child.Subtree.List.Count;
      this->Left.push_back(child);
    }
    return sum == place.Subtree.List.Count
      ? Status::Ok()
      : this->File.MakeCorrupt(place.Subtree.List.Page,
          "the node and its children do not have as many intervals as its parent says");
  }

  Result<Intervals> ReadList(const IntervalList& list)
  {
    Intervals records;
    PagedFileReader::Page payload;
    std::uint64_t current = 0;
    for (std::uint32_t index = 0; index < list.Count; ++index)
    {
      const std::uint64_t position = std::uint64_t{ list.Record } + index;
      const std::uint64_t page = list.Page + position / this->RecordsPerPage;
      if (this->RecordsLeft == 0)
      {
        return this->File.MakeCorrupt(page, "the tree leads to more intervals than its pages hold");
      }
      --this->RecordsLeft;
      if (!payload || page != current)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(auto read, this->File.ReadPage(page, this->Statistics));
        if (!IntervalRecordPage::IsOne(read->data()))
        {
          return this->File.MakeCorrupt(page, "this is not a page of intervals");
        }
        payload = std::move(read);
        current = page;
      }
      records.push_back(IntervalRecordPage::Get(
        payload->data(), static_cast<std::uint32_t>(position % this->RecordsPerPage)));
      if (records.back().Minimum > records.back().Maximum)
      {
        return this->File.MakeCorrupt(page, "an interval with its minimum above its maximum");
      }
    }
    return records;
  }

  void Count(const KeyInterval& interval)
  {
    ++this->Found;
    this->Minimum = std::min(this->Minimum, interval.Minimum);
    this->Maximum = std::max(this->Maximum, interval.Maximum);
  }

  const PagedFileReader& File;
  const IntervalTreeHeader& Header;
  PageStatistics& Statistics;
  std::uint32_t RecordsPerPage;
  std::uint64_t RecordsLeft;   ///< no two lists of a tree share records
  std::vector<bool> IsVisited; ///< by page: whether it is a node that was there before
  std::vector<Place> Left;     ///< to be visited
  std::uint64_t Found = 0;
  ValueKey Minimum = ~ValueKey{ 0 };
  ValueKey Maximum = 0;
};

} // namespace

Status VerifyIntervalTree(
  const PagedFileReader& file, const IntervalTreeHeader& header, PageStatistics& statistics)
{
  return IntervalTreeVerification(file, header, statistics).Run();
}

} // namespace isosurface
