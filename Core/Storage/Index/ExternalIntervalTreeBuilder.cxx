// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/ExternalIntervalTreeBuilder.h"

#include "Storage/Index/IntervalTreeFormat.h"
#include "Storage/Index/IntervalTreeNodePlan.h"
#include "Storage/Index/IntervalSorter.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/**
 * Packs lists of intervals into pages, one after the other. A list of at most B intervals follows
 * the previous one if it fits in the rest of the page; otherwise it begins a new page. A longer
 * list always begins a new page. So a short list costs one read, the first t intervals of a long
 * one at most 1 + t/B reads, and two successive pages hold more than B intervals together.
 */
class IntervalListWriter
{
public:
  explicit IntervalListWriter(PagedFileWriter& file)
    : File(file)
    , RecordsPerPage(IntervalTreeFormat::GetRecordsPerPage(file.GetPayloadSize()))
    , Payload(file.GetPayloadSize())
  {
  }

  std::uint32_t GetRecordsPerPage() const { return this->RecordsPerPage; }

  /// Begins a list of `count` intervals, which the caller then adds. Until then, only this object
  /// may allocate pages.
  Result<IntervalList> Begin(std::uint32_t count)
  {
    if (this->Page == 0 || (this->Record > 0 && this->RecordsPerPage - this->Record < count))
    {
      ISOSURFACE_RETURN_IF_ERROR(this->EndPage());
      ISOSURFACE_RETURN_IF_ERROR(this->BeginPage());
    }
    IntervalList list;
    list.Page = this->Page;
    list.Record = static_cast<std::uint16_t>(this->Record);
    list.Count = count;
    return list;
  }

  Status Add(const KeyInterval& interval)
  {
    if (this->Record == this->RecordsPerPage)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->EndPage());
      ISOSURFACE_RETURN_IF_ERROR(this->BeginPage());
    }
    IntervalRecordPage::Put(this->Payload.data(), this->Record++, interval);
    return Status::Ok();
  }

  /// Writes the last page.
  Status Finish() { return this->EndPage(); }

private:
  Status BeginPage()
  {
    ISOSURFACE_ASSIGN_OR_RETURN(this->Page, this->File.AllocatePage());
    this->Record = 0;
    std::fill(this->Payload.begin(), this->Payload.end(), std::uint8_t(0));
    IntervalRecordPage::Begin(this->Payload.data());
    return Status::Ok();
  }

  Status EndPage()
  {
    return this->Page == 0 ? Status::Ok() : this->File.WritePage(this->Page, this->Payload.data());
  }

  PagedFileWriter& File;
  std::uint32_t RecordsPerPage;
  std::vector<std::uint8_t> Payload;
  std::uint32_t Page = 0; // 0: none yet
  std::uint32_t Record = 0;
};

/**
 * The recursion of ExternalIntervalTreeBuilder: writes the pages of a subtree from its intervals,
 * which are sorted by Minimum and are in memory or in a temporary file. The order of the pages is:
 * lists of the node, its leaves, its other children, the node itself. So a page refers to pages
 * before it only, which guarantees that a query ends.
 */
class IntervalSubtreeWriter
{
public:
  IntervalSubtreeWriter(PagedFileWriter& file, TemporaryNames& names, std::size_t memoryLimit)
    : File(file)
    , Names(names)
    , SourceBytes(GetSourceBytes(memoryLimit))
    , RightBytes(GetSourceBytes(memoryLimit))
    , SpanBytes(5 * GetSourceBytes(memoryLimit))
    , BufferBytes(memoryLimit / 40)
    , Lists(file)
  {
  }

  /// The memory for the intervals of a subtree. As much again is for sorting the right lists of a
  /// node, five times as much for its multislab lists and windows (IntervalTreeNodePlan). So if
  /// the intervals fit, their lists fit as well.
  static std::size_t GetSourceBytes(std::size_t memoryLimit) { return memoryLimit / 8; }

  /// Takes a sorter by Minimum with all intervals; writes all pages except page 0.
  Result<IntervalSubtree> WriteTree(std::unique_ptr<IntervalSorter> sorter)
  {
    ISOSURFACE_RETURN_IF_ERROR(sorter->Sort());
    const auto count = static_cast<std::uint32_t>(sorter->GetCount());
    std::vector<IntervalRecord> memory;
    std::unique_ptr<TemporaryRecords> file;
    if (sorter->IsInMemory())
    {
      memory = sorter->TakeRecords();
    }
    else
    {
      ISOSURFACE_ASSIGN_OR_RETURN(file, TemporaryRecords::Create(this->Names, this->BufferBytes));
      Status status;
      while (const IntervalRecord* record = sorter->Next(status))
      {
        ISOSURFACE_RETURN_IF_ERROR(file->Append(*record));
      }
      ISOSURFACE_RETURN_IF_ERROR(status);
      ISOSURFACE_RETURN_IF_ERROR(file->FinishWriting());
      ISOSURFACE_RETURN_IF_ERROR(file->OpenForReading());
    }
    sorter.reset();
    auto root = this->WriteSubtree({ memory.data(), file.get(), 0, count });
    if (root.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Lists.Finish());
    }
    return root;
  }

private:
  /// Sorted intervals in memory, which writing the subtree may overwrite, or in a temporary file.
  struct Sequence
  {
    IntervalRecord* Memory;
    const TemporaryRecords* File;
    std::uint64_t First; // in the file
    std::uint32_t Count;
  };
  /// A node that is being written.
  struct NodeState
  {
    NodeState(IntervalSubtreeWriter& writer, std::vector<ValueKey> boundaries)
      : Plan(std::move(boundaries))
      , RightSorter(std::make_unique<IntervalSorter>(
          writer.Names, writer.RightBytes, IntervalSorter::Order::DescendingMaximum))
      , SpanSorter(std::make_unique<IntervalSorter>(
          writer.Names, writer.SpanBytes, IntervalSorter::Order::AscendingMinimum))
    {
      this->Node.Boundaries = this->Plan.GetBoundaries();
      this->Node.Slabs.resize(this->Plan.GetSlabCount());
    }

    IntervalTreeNodePlan Plan;
    IntervalTreeNode Node;
    std::unique_ptr<IntervalSorter> RightSorter; // grouped by slab
    std::unique_ptr<IntervalSorter> SpanSorter;  // grouped by the plan's groups
    // The intervals of all children, one child after the other:
    IntervalRecord* ChildMemory = nullptr; // moved to the front of the node's own
    std::unique_ptr<TemporaryRecords> ChildFile;
  };

  Result<IntervalSubtree> WriteSubtree(const Sequence& sequence)
  {
    if (sequence.Count == 0)
    {
      return IntervalSubtree();
    }
    if (sequence.File && sequence.Count <= IntervalSorter::GetMemoryRecords(this->SourceBytes))
    {
      std::vector<IntervalRecord> records(sequence.Count);
      ISOSURFACE_RETURN_IF_ERROR(
        sequence.File->Read(sequence.First, records.size(), records.data()));
      return this->WriteSubtree({ records.data(), nullptr, 0, sequence.Count });
    }
    return sequence.Count <= this->Lists.GetRecordsPerPage() ? this->WriteLeaf(sequence)
                                                             : this->WriteNode(sequence);
  }

  Result<IntervalSubtree> WriteLeaf(const Sequence& sequence)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto list, this->Lists.Begin(sequence.Count));
    ISOSURFACE_RETURN_IF_ERROR(this->ForEach(
      sequence, [this](const IntervalRecord& record) { return this->AddToList(record); }));
    IntervalSubtree leaf;
    leaf.List = list;
    return leaf;
  }

  Result<IntervalSubtree> WriteNode(const Sequence& sequence)
  {
    std::vector<ValueKey> boundaries;
    ISOSURFACE_RETURN_IF_ERROR(this->ChooseBoundaries(sequence, boundaries));
    NodeState state(*this, std::move(boundaries));
    ISOSURFACE_RETURN_IF_ERROR(this->ForEach(sequence,
      [&state](const IntervalRecord& record)
      {
        state.Plan.Count(state.Plan.Place(record.Minimum, record.Maximum));
        return Status::Ok();
      }));
    state.Plan.Decide(this->Lists.GetRecordsPerPage(),
      IntervalTreeNode::GetMultislabLimit(this->File.GetPayloadSize(), state.Plan.GetSlabCount()));
    ISOSURFACE_RETURN_IF_ERROR(this->Distribute(sequence, state));
    ISOSURFACE_RETURN_IF_ERROR(this->WriteRightLists(state));
    ISOSURFACE_RETURN_IF_ERROR(this->WriteSpanLists(state));
    ISOSURFACE_RETURN_IF_ERROR(this->WriteChildren(state));

    ISOSURFACE_ASSIGN_OR_RETURN(auto page, this->File.AllocatePage());
    std::vector<std::uint8_t> payload(this->File.GetPayloadSize());
    state.Node.Encode(payload.size(), payload.data());
    ISOSURFACE_RETURN_IF_ERROR(this->File.WritePage(page, payload.data()));
    IntervalSubtree subtree;
    subtree.List.Page = page;
    subtree.List.Count = sequence.Count;
    subtree.Height = state.Node.Height;
    return subtree;
  }

  Status ChooseBoundaries(const Sequence& sequence, std::vector<ValueKey>& boundaries) const
  {
    // If possible, as many slabs as make all children leaves. Strictly between two boundaries there
    // are at most n / slabs minima, so a child has at most as many intervals. Equal boundaries become
    // one: intervals that share a frequent minimum stay in this node.
    const std::uint32_t capacity = this->Lists.GetRecordsPerPage();
    const std::uint64_t slabs = std::min<std::uint64_t>(IntervalTreeFormat::GetSlabLimit(capacity),
      (std::uint64_t(sequence.Count) + capacity - 1) / capacity);
    for (std::uint64_t slab = 1; slab < slabs; ++slab)
    {
      const std::uint64_t rank = slab * sequence.Count / slabs;
      IntervalRecord record;
      if (sequence.Memory)
      {
        record = sequence.Memory[rank];
      }
      else
      {
        ISOSURFACE_RETURN_IF_ERROR(sequence.File->Read(sequence.First + rank, 1, &record));
      }
      if (boundaries.empty() || boundaries.back() < record.Minimum)
      {
        boundaries.push_back(record.Minimum);
      }
    }
    return Status::Ok();
  }

  Status Distribute(const Sequence& sequence, NodeState& state)
  {
    if (sequence.File)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        state.ChildFile, TemporaryRecords::Create(this->Names, this->BufferBytes));
    }
    state.ChildMemory = sequence.Memory;
    ISOSURFACE_RETURN_IF_ERROR(this->ForEach(sequence,
      [this, &state](const IntervalRecord& record) { return this->DistributeOne(record, state); }));
    if (state.ChildFile)
    {
      ISOSURFACE_RETURN_IF_ERROR(state.ChildFile->FinishWriting());
      return state.ChildFile->OpenForReading();
    }
    state.ChildMemory = sequence.Memory;
    return Status::Ok();
  }

  Status DistributeOne(const IntervalRecord& record, NodeState& state)
  {
    const auto placement = state.Plan.Place(record.Minimum, record.Maximum);
    if (placement.IsInChild())
    {
      if (state.ChildFile)
      {
        return state.ChildFile->Append(record);
      }
      *state.ChildMemory++ = record; // never ahead of the position that is read
      return Status::Ok();
    }
    // The intervals are sorted by Minimum, so those of a left list are consecutive and in its order.
    IntervalTreeSlab& slab = state.Node.Slabs[placement.First];
    if (slab.Left.Count == 0)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        slab.Left, this->Lists.Begin(state.Plan.GetLeftCount(placement.First)));
      slab.LeftMinimum = record.Minimum;
    }
    ISOSURFACE_RETURN_IF_ERROR(this->AddToList(record));
    IntervalRecord copy = record;
    if (placement.EndsInside)
    {
      copy.Group = placement.End;
      ISOSURFACE_RETURN_IF_ERROR(state.RightSorter->Add(copy));
    }
    if (placement.IsMultislab())
    {
      const auto groups = state.Plan.FindGroups(placement);
      for (copy.Group = groups.First; copy.Group < groups.End; ++copy.Group)
      {
        ISOSURFACE_RETURN_IF_ERROR(state.SpanSorter->Add(copy));
      }
    }
    return Status::Ok();
  }

  Status WriteRightLists(NodeState& state)
  {
    ISOSURFACE_RETURN_IF_ERROR(state.RightSorter->Sort());
    Status status;
    while (const IntervalRecord* record = state.RightSorter->Next(status))
    {
      IntervalTreeSlab& slab = state.Node.Slabs[record->Group];
      if (slab.Right.Count == 0)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(
          slab.Right, this->Lists.Begin(state.Plan.GetRightCount(record->Group)));
        slab.RightMaximum = record->Maximum;
      }
      ISOSURFACE_RETURN_IF_ERROR(this->AddToList(*record));
    }
    state.RightSorter.reset();
    return status;
  }

  Status WriteSpanLists(NodeState& state)
  {
    const auto& groups = state.Plan.GetGroups();
    std::vector<IntervalList> lists(groups.size());
    ISOSURFACE_RETURN_IF_ERROR(state.SpanSorter->Sort());
    Status status;
    while (const IntervalRecord* record = state.SpanSorter->Next(status))
    {
      if (lists[record->Group].Count == 0)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(auto list, this->Lists.Begin(groups[record->Group].Count));
        lists[record->Group] = list;
      }
      ISOSURFACE_RETURN_IF_ERROR(this->AddToList(*record));
    }
    ISOSURFACE_RETURN_IF_ERROR(status);
    state.SpanSorter.reset();

    const std::size_t multislabs = state.Plan.GetMultislabCount();
    for (std::size_t group = 0; group < multislabs; ++group)
    {
      state.Node.Multislabs.push_back({ groups[group].First, groups[group].Last, lists[group] });
    }
    state.Node.Windows.assign(lists.begin() + static_cast<std::ptrdiff_t>(multislabs), lists.end());
    for (std::size_t slab = 0; slab < state.Node.Slabs.size(); ++slab)
    {
      if (state.Plan.GetWindow(slab) >= 0)
      {
        state.Node.Slabs[slab].Window = static_cast<std::uint16_t>(
          static_cast<std::size_t>(state.Plan.GetWindow(slab)) - multislabs);
      }
    }
    return Status::Ok();
  }

  Status WriteChildren(NodeState& state)
  {
    // Leaves first, so that neighbouring leaves share pages.
    for (const bool leaves : { true, false })
    {
      std::uint64_t first = 0;
      for (std::size_t slab = 0; slab < state.Node.Slabs.size(); ++slab)
      {
        const std::uint32_t count = state.Plan.GetChildCount(slab);
        if ((count <= this->Lists.GetRecordsPerPage()) == leaves)
        {
          ISOSURFACE_ASSIGN_OR_RETURN(auto child,
            this->WriteSubtree({ state.ChildMemory ? state.ChildMemory + first : nullptr,
              state.ChildFile.get(), first, count }));
          state.Node.Slabs[slab].Child = child;
          state.Node.Height = std::max(state.Node.Height, child.Height + 1);
        }
        first += count;
      }
    }
    return Status::Ok();
  }

  Status AddToList(const IntervalRecord& record)
  {
    return this->Lists.Add({ record.Minimum, record.Maximum, record.Payload });
  }

  template <typename Visitor>
  Status ForEach(const Sequence& sequence, Visitor&& visit) const
  {
    if (sequence.Memory)
    {
      for (std::uint32_t index = 0; index < sequence.Count; ++index)
      {
        const IntervalRecord record = sequence.Memory[index]; // a copy: `visit` may overwrite it
        ISOSURFACE_RETURN_IF_ERROR(visit(record));
      }
      return Status::Ok();
    }
    TemporaryRecordStream stream(*sequence.File, sequence.First, sequence.Count, this->BufferBytes);
    Status status;
    while (const IntervalRecord* record = stream.Next(status))
    {
      ISOSURFACE_RETURN_IF_ERROR(visit(*record));
    }
    return status;
  }

  PagedFileWriter& File;
  TemporaryNames& Names;
  // Memory for:
  std::size_t SourceBytes; // the intervals of a subtree
  std::size_t RightBytes;  // sorting the right lists of a node
  std::size_t SpanBytes;   // sorting the multislab lists of a node
  std::size_t BufferBytes; // the buffer of a temporary file
  IntervalListWriter Lists;
};

} // namespace

ExternalIntervalTreeBuilder::ExternalIntervalTreeBuilder(
  FileSystem& fileSystem, std::string path, std::size_t memoryLimit, std::uint32_t pageSize)
  : Names{ fileSystem, path }
  , Path(std::move(path))
  , MemoryLimit(memoryLimit)
  , PageSize(pageSize)
  , Minimum(std::numeric_limits<ValueKey>::max())
  , Maximum(0)
{
  if (memoryLimit < MinimumMemoryLimit)
  {
    this->FirstError = Status(StatusCode::InvalidArgument,
      this->Path + ": an interval tree cannot be built in " + std::to_string(memoryLimit) +
        " bytes; it takes at least " + std::to_string(MinimumMemoryLimit));
    return;
  }
  this->Sorter = std::make_unique<IntervalSorter>(this->Names,
    IntervalSubtreeWriter::GetSourceBytes(memoryLimit), IntervalSorter::Order::AscendingMinimum);
}

ExternalIntervalTreeBuilder::~ExternalIntervalTreeBuilder() = default;

Status ExternalIntervalTreeBuilder::Add(const KeyInterval& interval)
{
  ISOSURFACE_RETURN_IF_ERROR(this->FirstError);
  Status status = this->Check(interval);
  if (status.IsOk())
  {
    status =
      this->Sorter->Add({ interval.Minimum, interval.Maximum, interval.Payload, /*Group=*/0 });
  }
  if (!status.IsOk())
  {
    this->FirstError = status;
    this->Sorter.reset();
    return status;
  }
  ++this->Count;
  this->Minimum = std::min(this->Minimum, interval.Minimum);
  this->Maximum = std::max(this->Maximum, interval.Maximum);
  return Status::Ok();
}

Status ExternalIntervalTreeBuilder::Finish()
{
  ISOSURFACE_RETURN_IF_ERROR(this->FirstError);
  const std::string temporary = this->Path + ".tmp";
  Status status = this->Write(temporary);
  this->Sorter.reset();
  if (status.IsOk())
  {
    status = this->Names.Files.Rename(temporary, this->Path);
  }
  if (!status.IsOk())
  {
    static_cast<void>(this->Names.Files.RemoveAll(temporary));
    this->FirstError = status;
    return status;
  }
  this->FirstError =
    Status(StatusCode::InvalidArgument, this->Path + ": the interval tree is written already");
  return Status::Ok();
}

Status ExternalIntervalTreeBuilder::Check(const KeyInterval& interval) const
{
  if (interval.Minimum > interval.Maximum)
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": interval " + std::to_string(interval.Payload) +
        " has its minimum above its maximum");
  }
  if (this->Count == std::numeric_limits<std::uint32_t>::max())
  {
    return Status(StatusCode::Unsupported, this->Path + ": 2^32 or more intervals");
  }
  return Status::Ok();
}

Status ExternalIntervalTreeBuilder::Write(const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file,
    PagedFileWriter::Create(this->Names.Files, path, this->PageSize, IntervalTreeFormat::Kind));
  IntervalSubtreeWriter writer(*file, this->Names, this->MemoryLimit);
  ISOSURFACE_ASSIGN_OR_RETURN(auto root, writer.WriteTree(std::move(this->Sorter)));
  IntervalTreeHeader header;
  header.Count = this->Count;
  header.Identity = this->Identity;
  header.Root = root;
  header.Minimum = this->Minimum;
  header.Maximum = this->Maximum;
  ISOSURFACE_RETURN_IF_ERROR(file->Finish(header.Encode()));
  this->Seal = file->GetSeal();
  return Status::Ok();
}

} // namespace isosurface
