// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalSorter_h
#define isosurface_IntervalSorter_h

#include "Ground/Base/Status.h"
#include "Storage/Index/TemporaryRecords.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * Sorts records within a byte budget: in memory if they fit, otherwise by an external merge sort
 * with temporary files, which are read and written sequentially. The order is total, so the result
 * does not depend on the order of the input.
 *
 * Usage: Add() all records, Sort(), then Next() until null. The destructor removes the temporary
 * files.
 */
class IntervalSorter
{
public:
  enum class Order : std::uint8_t
  {
    AscendingMinimum, ///< by group, then Minimum, Maximum, payload
    DescendingMaximum ///< by group, then Maximum downwards, Minimum, payload
  };

  IntervalSorter(TemporaryNames& names, std::size_t memoryBytes, Order order);
  ~IntervalSorter();
  IntervalSorter(const IntervalSorter&) = delete;
  IntervalSorter& operator=(const IntervalSorter&) = delete;

  /// The maximum number of records that a sorter of this budget sorts without temporary files.
  static std::size_t GetMemoryRecords(std::size_t memoryBytes);

  Status Add(const IntervalRecord& record);
  Status Sort();
  std::uint64_t GetCount() const { return this->Count; }

  /// The next record in order; null at the end, or on an error: see `status`.
  const IntervalRecord* Next(Status& status);

  /// Whether there are no temporary files. Then TakeRecords() gives all records after Sort().
  bool IsInMemory() const { return this->Runs.empty(); }
  std::vector<IntervalRecord> TakeRecords() { return std::move(this->Records); }

private:
  class Merge;

  bool IsBefore(const IntervalRecord& a, const IntervalRecord& b) const;
  void SortMemory();
  Status WriteRun();
  Status MergeFirstRuns(std::size_t count);

  TemporaryNames& Names;
  std::size_t MemoryBytes;
  Order RecordOrder;
  std::uint64_t Count = 0;
  std::vector<IntervalRecord> Records;
  std::size_t Position = 0;
  std::vector<std::unique_ptr<TemporaryRecords>> Runs;
  std::unique_ptr<Merge> FinalMerge;
};

} // namespace isosurface

#endif
