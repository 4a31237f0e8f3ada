// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalSubtreeWriter_h
#define isosurface_IntervalSubtreeWriter_h

#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Storage/Index/IntervalSorter.h"
#include "Storage/Index/IntervalTreeFormat.h"
#include "Storage/Index/IntervalTreeNodePlan.h"
#include "Storage/Index/TemporaryRecords.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
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
  explicit IntervalListWriter(PagedFileWriter& file);

  std::uint32_t GetRecordsPerPage() const { return this->RecordsPerPage; }

  /// Begins a list of `count` intervals, which the caller then adds. Until then, only this object
  /// may allocate pages.
  Result<IntervalList> Begin(std::uint32_t count);
  Status Add(const KeyInterval& interval);
  /// Writes the last page.
  Status Finish();

private:
  Status BeginPage();
  Status EndPage();

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
  IntervalSubtreeWriter(PagedFileWriter& file, TemporaryNames& names, std::size_t memoryLimit);

  /// The memory for the intervals of a subtree. As much again is for sorting the right lists of a
  /// node, five times as much for its multislab lists and windows (IntervalTreeNodePlan). So if
  /// the intervals fit, their lists fit as well.
  static std::size_t GetSourceBytes(std::size_t memoryLimit) { return memoryLimit / 8; }

  /// Takes a sorter by Minimum with all intervals; writes all pages except page 0.
  Result<IntervalSubtree> WriteTree(std::unique_ptr<IntervalSorter> sorter);

private:
  /// Sorted intervals in memory, which writing the subtree may overwrite, or in a temporary file.
  struct Sequence
  {
    IntervalRecord* Memory;
    const TemporaryRecords* File;
    std::uint64_t First; // in the file
    std::uint32_t Count;
  };
  struct NodeState;

  Result<IntervalSubtree> WriteSubtree(const Sequence& sequence);
  Result<IntervalSubtree> WriteLeaf(const Sequence& sequence);
  Result<IntervalSubtree> WriteNode(const Sequence& sequence);
  Status ChooseBoundaries(const Sequence& sequence, std::vector<ValueKey>& boundaries) const;
  Status Distribute(const Sequence& sequence, NodeState& state);
  Status DistributeOne(const IntervalRecord& record, NodeState& state);
  Status WriteRightLists(NodeState& state);
  Status WriteSpanLists(NodeState& state);
  Status WriteChildren(NodeState& state);
  Status AddToList(const IntervalRecord& record);

  template <typename Visitor>
  Status ForEach(const Sequence& sequence, Visitor&& visit) const;

  PagedFileWriter& File;
  TemporaryNames& Names;
  // Memory for:
  std::size_t SourceBytes; // the intervals of a subtree
  std::size_t RightBytes;  // sorting the right lists of a node
  std::size_t SpanBytes;   // sorting the multislab lists of a node
  std::size_t BufferBytes; // the buffer of a temporary file
  IntervalListWriter Lists;
};

} // namespace isosurface

#endif
