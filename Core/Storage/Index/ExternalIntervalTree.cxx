// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/ExternalIntervalTree.h"

#include "Storage/Index/IntervalTreeVerification.h"

#include <utility>
#include <vector>

namespace isosurface
{

/**
 * One query. It uses a stack instead of recursion. It ends on any pages, even hostile ones: a node
 * refers to pages before it only, and the pages visited, the records read and the intervals
 * reported are limited by the maximum for a valid tree of this size.
 */
class ExternalIntervalTree::Query
{
public:
  Query(const ExternalIntervalTree& tree, ValueKey low, ValueKey high, const Visitor& visit,
    PageStatistics& statistics)
    : File(*tree.File)
    , Header(tree.Header)
    , RecordsPerPage(tree.GetRecordsPerPage())
    , Low(low)
    , High(high)
    , Visit(visit)
    , Statistics(statistics)
    , VisitsLeft(64 + 16 * tree.GetPageCount())
    , RecordsLeft(tree.GetPageCount() * RecordsPerPage)
    , ReportsLeft(tree.GetCount())
  {
  }

  Status Run()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Enter(this->Header.Root));
    while (!this->Nodes.empty())
    {
      const IntervalSubtree next = this->Nodes.back();
      this->Nodes.pop_back();
      ISOSURFACE_RETURN_IF_ERROR(this->VisitNode(next));
    }
    return Status::Ok();
  }

private:
  using Page = PagedFileReader::Page;

  /// The order of the records in a list.
  enum class ListOrder : std::uint8_t
  {
    AscendingMinimum,  // the answers are a prefix
    DescendingMaximum, // the answers are a prefix
    None               // the answers may be anywhere
  };

  Status Enter(const IntervalSubtree& subtree)
  {
    if (subtree.Height == 0)
    {
      return this->ReadList(subtree.List, ListOrder::None);
    }
    this->Nodes.push_back(subtree);
    return Status::Ok();
  }

  Status VisitNode(const IntervalSubtree& subtree)
  {
    const std::uint32_t number = subtree.List.Page;
    ISOSURFACE_ASSIGN_OR_RETURN(const auto page, this->ReadPage(number));
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto node, IntervalTreeNode::Decode(this->File, number, page->data()));
    if (node.Height != subtree.Height)
    {
      return this->File.MakeCorrupt(number, "a node of another height than its parent says");
    }
    const std::size_t first = node.FindSlab(this->Low);
    const std::size_t last = node.FindSlab(this->High);
    ISOSURFACE_RETURN_IF_ERROR(this->ReadLeftLists(node, first, last));
    ISOSURFACE_RETURN_IF_ERROR(this->ReadListsAcross(node, first));
    return this->EnterChildren(node, first, last);
  }

  /// Reports the intervals whose minimum is in the query's slabs and not above its end.
  Status ReadLeftLists(const IntervalTreeNode& node, std::size_t first, std::size_t last)
  {
    for (std::size_t slab = first; slab <= last; ++slab)
    {
      if (node.Slabs[slab].Left.Count > 0 && node.Slabs[slab].LeftMinimum <= this->High)
      {
        ISOSURFACE_RETURN_IF_ERROR(
          this->ReadList(node.Slabs[slab].Left, ListOrder::AscendingMinimum));
      }
    }
    return Status::Ok();
  }

  /// Reports the intervals whose minimum is below the slab in which the query begins.
  Status ReadListsAcross(const IntervalTreeNode& node, std::size_t slab)
  {
    const IntervalTreeSlab& entry = node.Slabs[slab];
    if (entry.Right.Count > 0 && entry.RightMaximum >= this->Low)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ReadList(entry.Right, ListOrder::DescendingMaximum));
    }
    for (const IntervalTreeMultislab& multislab : node.Multislabs)
    {
      if (multislab.First <= slab && slab <= multislab.Last)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->ReadList(multislab.List, ListOrder::None));
      }
    }
    return entry.Window == IntervalTreeSlab::NoWindow
      ? Status::Ok()
      : this->ReadWindow(node.Windows[entry.Window], node, slab);
  }

  Status EnterChildren(const IntervalTreeNode& node, std::size_t first, std::size_t last)
  {
    for (std::size_t slab = first; slab <= last; ++slab)
    {
      // All intervals of a child lie below the upper boundary of its slab.
      const bool isBelow = slab < node.Boundaries.size() && node.Boundaries[slab] == this->Low;
      if (node.Slabs[slab].Child.List.Count > 0 && !isBelow)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->Enter(node.Slabs[slab].Child));
      }
    }
    return Status::Ok();
  }

  Status ReadList(const IntervalList& list, ListOrder order)
  {
    KeyInterval before;
    for (std::uint32_t index = 0; index < list.Count; ++index)
    {
      KeyInterval interval;
      ISOSURFACE_RETURN_IF_ERROR(this->GetRecord(list, index, interval));
      if (index > 0 &&
        ((order == ListOrder::AscendingMinimum && interval.Minimum < before.Minimum) ||
          (order == ListOrder::DescendingMaximum && interval.Maximum > before.Maximum)))
      {
        return this->File.MakeCorrupt(this->RecordPageNumber, "a list is not in order");
      }
      if (interval.Overlaps(this->Low, this->High))
      {
        ISOSURFACE_RETURN_IF_ERROR(this->Report(interval));
      }
      else if (order != ListOrder::None)
      {
        return Status::Ok();
      }
      before = interval;
    }
    return Status::Ok();
  }

  /// Reports the intervals of a window that span this slab. Other intervals of the window may
  /// overlap the query's range, too, but their minimum is in or above this slab: their left list
  /// reports them.
  Status ReadWindow(const IntervalList& list, const IntervalTreeNode& node, std::size_t slab)
  {
    for (std::uint32_t index = 0; index < list.Count; ++index)
    {
      KeyInterval interval;
      ISOSURFACE_RETURN_IF_ERROR(this->GetRecord(list, index, interval));
      const bool spans = slab > 0 && interval.Minimum <= node.Boundaries[slab - 1] &&
        slab < node.Boundaries.size() && interval.Maximum >= node.Boundaries[slab];
      if (spans && interval.Overlaps(this->Low, this->High))
      {
        ISOSURFACE_RETURN_IF_ERROR(this->Report(interval));
      }
    }
    return Status::Ok();
  }

  /// Gets a record of a list. Reads its page unless that was the last page read.
  Status GetRecord(const IntervalList& list, std::uint32_t index, KeyInterval& interval)
  {
    const std::uint64_t position = std::uint64_t(list.Record) + index;
    const std::uint64_t number = list.Page + position / this->RecordsPerPage;
    if (this->RecordsLeft == 0)
    {
      return this->File.MakeCorrupt(number, "the tree leads to more intervals than its pages hold");
    }
    --this->RecordsLeft;
    if (!this->RecordPage || number != this->RecordPageNumber)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto page, this->ReadPage(number));
      if (!IntervalRecordPage::IsOne(page->data()))
      {
        return this->File.MakeCorrupt(number, "this is not a page of intervals");
      }
      this->RecordPage = std::move(page);
      this->RecordPageNumber = number;
    }
    interval = IntervalRecordPage::Get(
      this->RecordPage->data(), static_cast<std::uint32_t>(position % this->RecordsPerPage));
    if (interval.Minimum > interval.Maximum)
    {
      return this->File.MakeCorrupt(number, "an interval with its minimum above its maximum");
    }
    return Status::Ok();
  }

  Result<Page> ReadPage(std::uint64_t number)
  {
    if (this->VisitsLeft == 0)
    {
      return this->File.MakeCorrupt(number, "the tree leads to more pages than it can have");
    }
    --this->VisitsLeft;
    return this->File.ReadPage(number, this->Statistics);
  }

  Status Report(const KeyInterval& interval)
  {
    if (this->ReportsLeft == 0)
    {
      return this->File.MakeCorrupt(
        this->RecordPageNumber, "more intervals are found than the tree has");
    }
    --this->ReportsLeft;
    this->Visit(interval);
    return Status::Ok();
  }

  const PagedFileReader& File;
  const IntervalTreeHeader& Header;
  const std::uint32_t RecordsPerPage;
  const ValueKey Low;
  const ValueKey High;
  const Visitor& Visit;
  PageStatistics& Statistics;
  std::uint64_t VisitsLeft;
  std::uint64_t RecordsLeft; // no two lists of a tree share records
  std::uint64_t ReportsLeft;
  std::vector<IntervalSubtree> Nodes; // to be visited
  Page RecordPage;                    // the last one read
  std::uint64_t RecordPageNumber = 0;
};

Result<std::unique_ptr<ExternalIntervalTree>> ExternalIntervalTree::Open(
  FileSystem& fileSystem, const std::string& path, std::size_t cacheBytes)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, fileSystem.OpenForReading(path));
  return Open(std::move(file), cacheBytes);
}

Result<std::unique_ptr<ExternalIntervalTree>> ExternalIntervalTree::Open(
  std::unique_ptr<RandomAccessFile> file, std::size_t cacheBytes)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto pages, PagedFileReader::Open(std::move(file), IntervalTreeFormat::Kind, cacheBytes));
  std::unique_ptr<ExternalIntervalTree> tree(new ExternalIntervalTree(std::move(pages)));
  ISOSURFACE_ASSIGN_OR_RETURN(tree->Header, IntervalTreeHeader::Decode(*tree->File));
  return tree;
}

ExternalIntervalTree::ExternalIntervalTree(std::unique_ptr<PagedFileReader> file)
  : File(std::move(file))
{
}

std::uint32_t ExternalIntervalTree::GetRecordsPerPage() const
{
  return IntervalTreeFormat::GetRecordsPerPage(this->File->GetPayloadSize());
}

Status ExternalIntervalTree::FindStabbed(
  ValueKey key, const Visitor& visit, PageStatistics& statistics) const
{
  return this->FindOverlapping(key, key, visit, statistics);
}

Status ExternalIntervalTree::FindOverlapping(
  ValueKey low, ValueKey high, const Visitor& visit, PageStatistics& statistics) const
{
  if (low > high || low > this->Header.Maximum || high < this->Header.Minimum)
  {
    return Status::Ok();
  }
  return Query(*this, low, high, visit, statistics).Run();
}

Status ExternalIntervalTree::Verify(PageStatistics& statistics) const
{
  for (std::uint64_t page = 0; page < this->File->GetPageCount(); ++page)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->File->ReadPage(page, statistics).GetStatus());
  }
  return VerifyIntervalTree(*this->File, this->Header, statistics);
}

} // namespace isosurface
