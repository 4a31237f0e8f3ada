// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExternalIntervalTree_h
#define isosurface_ExternalIntervalTree_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Index/IntervalTreeFormat.h"
#include "Index/KeyInterval.h"
#include "Index/PagedFile.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace isosurface
{

/**
 * Finds, in a file, the intervals that contain a key or overlap a range. Intervals are closed.
 *
 * Cost, without a cache, for N intervals, T of them reported, B = (page size - 16) / 20 intervals
 * a page, fan-out s = 2 floor(sqrt(B)):
 * - FindStabbed:     at most 1 + 4 h + 2 T/B page reads, h = ceil(log_s(N/B)), so at most
 *                    7 log_B max(N, B) + 2 T/B; at most h + 1 if T = 0;
 * - FindOverlapping: at most 1 + 13 h + 6 T/B (at most 2 + 9 h + 6 T/B measured);
 * - the file:        at most 16 N/B + 2 pages for any intervals (at most 5.4 N/B measured).
 * A query keeps one record page and the nodes of its path in memory, besides the cache.
 *
 * Lars Arge and Jeffrey Scott Vitter, "Optimal external memory interval management", SIAM Journal
 * on Computing 32(6), 2003, in static form, as Yi-Jen Chiang and Claudio Silva use it ("I/O optimal
 * isosurface extraction", IEEE Visualization 1997). Deviations: lists are packed into pages, where
 * one page may hold several; the underflow list is cut into windows by filtering search instead of
 * a corner structure (see IntervalTreeNodePlan); a node knows the extreme key of each left and
 * right list, so that a list without an answer is not read; range queries.
 *
 * Any number of threads may query one tree.
 *
 * Errors: NotFound, IoError, Corrupt and Unsupported as those of PagedFileReader; Corrupt also
 * where pages with right checksums contradict each other. What a failed query reported is to be
 * dropped.
 */
class ExternalIntervalTree
{
public:
  using Visitor = std::function<void(const KeyInterval&)>;

  /// Opens a tree; reads page 0. `cacheBytes` bounds the page cache, 0 means none.
  static Result<std::unique_ptr<ExternalIntervalTree>> Open(
    FileSystem& fileSystem, const std::string& path, std::size_t cacheBytes);
  static Result<std::unique_ptr<ExternalIntervalTree>> Open(
    std::unique_ptr<RandomAccessFile> file, std::size_t cacheBytes);

  /// The number of intervals.
  std::uint64_t GetCount() const { return this->Header.Count; }
  /// The number of pages of the file, page 0 included.
  std::uint64_t GetPageCount() const { return this->File->GetPageCount(); }
  std::uint32_t GetRecordsPerPage() const;
  /// The least Minimum and the greatest Maximum; Least > Greatest if there is no interval.
  ValueKey GetLeast() const { return this->Header.Least; }
  ValueKey GetGreatest() const { return this->Header.Greatest; }

  /// Reports each interval with Minimum <= key <= Maximum exactly once, in no particular order,
  /// and adds what it cost to `statistics`.
  Status FindStabbed(ValueKey key, const Visitor& visit, PageStatistics& statistics) const;

  /// Reports each interval that overlaps [low, high] exactly once; none if low > high.
  Status FindOverlapping(
    ValueKey low, ValueKey high, const Visitor& visit, PageStatistics& statistics) const;

  /// Reads every page and follows every reference that leads to an interval: Ok if all checksums
  /// are right and the tree gives as many intervals as it says it has.
  Status Verify(PageStatistics& statistics) const;

private:
  class Query;
  explicit ExternalIntervalTree(std::unique_ptr<PagedFileReader> file);

  std::unique_ptr<PagedFileReader> File;
  IntervalTreeHeader Header;
};

} // namespace isosurface

#endif
