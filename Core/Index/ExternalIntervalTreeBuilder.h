// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExternalIntervalTreeBuilder_h
#define isosurface_ExternalIntervalTreeBuilder_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Index/IntervalSorter.h"
#include "Index/KeyInterval.h"
#include "Index/PagedFile.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace isosurface
{

/**
 * Writes the file that ExternalIntervalTree reads: Add() the intervals in any order, then Finish().
 *
 * Memory: at most `memoryLimit` bytes, whatever the number of intervals. Up to memoryLimit / 240
 * intervals are sorted in memory, without temporary files; more go through temporary files beside
 * the target (<path>.<n>.tmp, at most about 200 bytes an interval at a time, commonly 70). The tree
 * is written to <path>.tmp, brought to stable storage and renamed; an error, or giving up the
 * builder, leaves no file behind and one that was at the path as it was.
 *
 * The same set of intervals gives the same bytes, whatever their order and the memory limit.
 *
 * Method: intervals are sorted by Minimum once (external merge sort). A node takes every
 * (n/s)-th Minimum as a slab boundary, so that no child gets more than n/s intervals, distributes
 * its intervals in one pass (left lists and children come out sorted), and sorts the right lists
 * and the multislab lists externally: O(N/B log_s N/B) page transfers in all.
 *
 * Errors (the first one is given again by all later calls): InvalidArgument (an interval with
 * Minimum > Maximum, a memory limit below LeastMemoryLimit, a page size that is none), Unsupported
 * (2^32 intervals or pages), those of the file system.
 */
class ExternalIntervalTreeBuilder
{
public:
  static constexpr std::size_t LeastMemoryLimit = 2 * 1024 * 1024;

  ExternalIntervalTreeBuilder(FileSystem& fileSystem, std::string path, std::size_t memoryLimit,
    std::uint32_t pageSize = PagedFile::DefaultPageSize);
  ~ExternalIntervalTreeBuilder();
  ExternalIntervalTreeBuilder(const ExternalIntervalTreeBuilder&) = delete;
  ExternalIntervalTreeBuilder& operator=(const ExternalIntervalTreeBuilder&) = delete;

  Status Add(const KeyInterval& interval);
  /// Writes the tree. Called once, last.
  Status Finish();

  std::uint64_t GetCount() const { return this->Count; }

private:
  Status Check(const KeyInterval& interval) const;
  Status Write(const std::string& path);

  TemporaryNames Names;
  std::string Path;
  std::size_t MemoryLimit;
  std::uint32_t PageSize;
  std::uint64_t Count = 0;
  ValueKey Least;
  ValueKey Greatest;
  std::unique_ptr<IntervalSorter> Sorter;
  Status FirstError;
};

} // namespace isosurface

#endif
