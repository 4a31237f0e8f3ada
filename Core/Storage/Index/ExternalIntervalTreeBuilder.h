// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExternalIntervalTreeBuilder_h
#define isosurface_ExternalIntervalTreeBuilder_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Storage/Index/IntervalSorter.h"
#include "Storage/Index/IntervalTreeFormat.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace isosurface
{

/**
 * Writes the file that ExternalIntervalTree reads: Add() the intervals in any order, then Finish().
 * The bytes depend on the set of intervals only, not on their order or the memory limit.
 *
 * Memory: at most `memoryLimit` bytes for any number of intervals. Up to memoryLimit / 240
 * intervals are sorted in memory; more need temporary files beside the target (PATH.N.tmp, at
 * most about 200 bytes an interval, usually 70). The tree is written to PATH.tmp and then
 * renamed. An error, or a builder that is not finished, leaves no new file and does not change an
 * existing one.
 *
 * Method: Documentation/formats/interval-tree.md, Building. Cost: O(N/B log_s N/B) page transfers
 * for N intervals.
 *
 * Errors (all calls after an error return that error): InvalidArgument (an interval with Minimum >
 * Maximum, a memory limit below MinimumMemoryLimit, an invalid page size), Unsupported (2^32
 * intervals or pages), those of the file system.
 */
class ExternalIntervalTreeBuilder
{
public:
  static constexpr std::size_t MinimumMemoryLimit = 2 * 1024 * 1024;

  ExternalIntervalTreeBuilder(FileSystem& fileSystem, std::string path, std::size_t memoryLimit,
    std::uint32_t pageSize = PagedFile::DefaultPageSize);
  ~ExternalIntervalTreeBuilder();
  ExternalIntervalTreeBuilder(const ExternalIntervalTreeBuilder&) = delete;
  ExternalIntervalTreeBuilder& operator=(const ExternalIntervalTreeBuilder&) = delete;

  /// A number that the file keeps in its sealed header. A reader that knows which one to expect
  /// finds out about a file that is whole but of something else.
  void SetIdentity(std::uint64_t identity) { this->Identity = identity; }

  Status Add(const KeyInterval& interval);
  /// Writes the tree. Called once, last.
  Status Finish();

  /// What stands for every byte of the file, after Finish() (PagedFile.h).
  std::uint64_t GetSeal() const { return this->Seal; }

  std::uint64_t GetCount() const { return this->Count; }

private:
  Status Check(const KeyInterval& interval) const;
  Status Write(const std::string& path);

  TemporaryNames Names;
  std::string Path;
  std::size_t MemoryLimit;
  std::uint32_t PageSize;
  std::uint64_t Count = 0;
  std::uint64_t Identity = 0;
  std::uint64_t Seal = 0;
  ValueKey Minimum; ///< of all intervals
  ValueKey Maximum;
  std::unique_ptr<IntervalSorter> Sorter;
  Status FirstError;
};

} // namespace isosurface

#endif
