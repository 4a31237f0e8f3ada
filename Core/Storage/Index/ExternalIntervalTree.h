// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExternalIntervalTree_h
#define isosurface_ExternalIntervalTree_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Storage/Index/IntervalTreeFormat.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace isosurface
{

/**
 * Finds the intervals in a file that contain a key or overlap a range. Intervals are closed. Any
 * number of threads may query a tree.
 *
 * Source: L. Arge, J. S. Vitter, "Optimal external memory interval management", SIAM Journal on
 * Computing 32(6), 2003, without updates, as Y.-J. Chiang and C. Silva use it ("I/O optimal
 * isosurface extraction", IEEE Visualization 1997). Deviations:
 * Documentation/formats/interval-tree.md.
 *
 * Cost without a cache, for N intervals of which T are reported, B = (page size - 16) / 20
 * intervals a page, fan-out s = 2 floor(sqrt(B)), h = ceil(log_s(N/B)): FindStabbed reads at most 1
 * + 4 h + 2 T/B pages, FindOverlapping 1 + 13 h + 6 T/B. The file has at most 16 N/B + 2 pages.
 * Memory: the cache, a page of records and the nodes on the path of the query.
 *
 * Errors: those of PagedFileReader; Corrupt also if pages with matching checksums contradict each
 * other. If a query fails, ignore what it has reported.
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
  /// What the intervals are of, as ExternalIntervalTreeBuilder::SetIdentity() had it.
  std::uint64_t GetIdentity() const { return this->Header.Identity; }
  /// Corrupt unless the file is the one whose builder had this seal.
  Status CheckSeal(std::uint64_t seal) const { return this->File->CheckSeal(seal); }
  /// An error that names the file.
  Status MakeCorrupt(const std::string& reason) const { return this->File->MakeCorrupt(0, reason); }
  /// The number of pages of the file, page 0 included.
  std::uint64_t GetPageCount() const { return this->File->GetPageCount(); }
  std::uint32_t GetRecordsPerPage() const;

  /// Reports each interval with Minimum <= key <= Maximum exactly once, in no particular order.
  /// Adds the pages that it reads to `statistics`.
  Status FindStabbed(ValueKey key, const Visitor& visit, PageStatistics& statistics) const;

  /// Reports each interval that overlaps [low, high] exactly once; none if low > high.
  Status FindOverlapping(
    ValueKey low, ValueKey high, const Visitor& visit, PageStatistics& statistics) const;

  /// Reads every page and follows every reference. Ok if all checksums match and every query gives
  /// what the intervals demand (IntervalTreeVerification).
  Status Verify(PageStatistics& statistics) const;

private:
  class Query;
  explicit ExternalIntervalTree(std::unique_ptr<PagedFileReader> file);

  std::unique_ptr<PagedFileReader> File;
  IntervalTreeHeader Header;
};

} // namespace isosurface

#endif
