// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalTreeVerification_h
#define isosurface_IntervalTreeVerification_h

#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Storage/Index/IntervalTreeFormat.h"
#include "Storage/Index/KeyInterval.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Checks that an external interval tree answers every query as its intervals demand: each interval
 * is in all the lists of a node that it has to be in, in their order, and nowhere else; the bounds
 * by which queries leave out lists, subtrees or the whole tree are those of the intervals there
 * (Documentation/formats/interval-tree.md). Matching checksums do not show that: a program may have
 * written them over a wrong bound.
 *
 * Cost: reads each page once. Memory: the intervals of the largest node.
 */
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
  Status Run();

private:
  using Intervals = std::vector<KeyInterval>;

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

  Status VisitLeaf(const Place& place);
  Status VisitNode(const Place& place);
  Status CheckLeft(const Place& place, const IntervalTreeNode& node, Expected& expected);
  Status CheckRight(std::uint32_t page, const IntervalTreeNode& node, Expected& expected);
  Status CheckMultislabs(std::uint32_t page, const IntervalTreeNode& node, Expected& expected);
  Status CheckWindows(std::uint32_t page, const IntervalTreeNode& node, const Expected& expected);
  Status AddChildren(const Place& place, const IntervalTreeNode& node, std::uint64_t own);
  Result<Intervals> ReadList(const IntervalList& list);
  void Count(const KeyInterval& interval);

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

} // namespace isosurface

#endif
