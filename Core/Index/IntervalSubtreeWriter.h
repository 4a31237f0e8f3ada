// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalSubtreeWriter_h
#define isosurface_IntervalSubtreeWriter_h

#include "Base/Status.h"
#include "Index/IntervalListWriter.h"
#include "Index/IntervalSorter.h"
#include "Index/IntervalTreeFormat.h"
#include "Index/IntervalTreeNodePlan.h"
#include "Index/PagedFile.h"
#include "Index/TemporaryRecords.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The recursion of ExternalIntervalTreeBuilder: writes the pages of a subtree from its intervals,
 * sorted by Minimum, which lie in memory or in a temporary file. Pages come in the order: lists of
 * the node, its leaves, its other children, the node itself. So everything that a page refers to
 * lies before it, which is how a reader knows that it will come to an end.
 */
class IntervalSubtreeWriter
{
public:
  IntervalSubtreeWriter(PagedFileWriter& file, TemporaryNames& names, std::size_t memoryLimit);

  /// The share of a memory limit that may hold the intervals of a subtree. One such share more is
  /// for sorting the right lists of a node, five are for its multislab lists (see the bound of
  /// IntervalTreeNodePlan): what fits the first fits the others.
  static std::size_t GetSourceBytes(std::size_t memoryLimit) { return memoryLimit / 8; }

  /// Takes a sorter by Minimum to which everything has been added; writes all pages but page 0.
  Result<IntervalSubtree> WriteTree(std::unique_ptr<IntervalSorter> sorter);

private:
  /// Sorted intervals, in memory (which the subtree may overwrite) or in a temporary file.
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
  std::size_t SourceBytes; // a subtree's intervals
  std::size_t RightBytes;  // sorting the right lists of one node
  std::size_t SpanBytes;   // sorting the multislab lists of one node
  std::size_t BufferBytes; // a stream from or to a temporary file
  IntervalListWriter Lists;
};

} // namespace isosurface

#endif
