// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalSorter_h
#define isosurface_IntervalSorter_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// An interval that is being sorted, with the number of the list to which it belongs.
struct IntervalRecord
{
  ValueKey Minimum;
  ValueKey Maximum;
  std::uint32_t Payload;
  std::uint32_t Group;
};
static_assert(sizeof(IntervalRecord) == 24, "the records of temporary files have no padding");

/// Makes names of temporary files beside the target: TARGET.NUMBER.tmp.
struct TemporaryNames
{
  FileSystem& Files;
  std::string Target;
  std::uint64_t Next = 0;

  std::string Make() { return this->Target + "." + std::to_string(this->Next++) + ".tmp"; }
};

/**
 * A temporary file of records, written once and then read any number of times. The destructor
 * removes it. It holds the records as they are in memory, since no other machine reads it.
 */
class TemporaryRecords
{
public:
  /// The file is written through a buffer of `bufferBytes`, which FinishWriting() frees.
  static Result<std::unique_ptr<TemporaryRecords>> Create(
    TemporaryNames& names, std::size_t bufferBytes);
  ~TemporaryRecords();
  TemporaryRecords(const TemporaryRecords&) = delete;
  TemporaryRecords& operator=(const TemporaryRecords&) = delete;

  Status Append(const IntervalRecord& record);
  /// Closes the file: a sort can have more of them than a process may hold open.
  Status FinishWriting();
  Status OpenForReading();

  std::uint64_t GetCount() const { return this->Count; }
  /// Reads records first .. first + count - 1; only after OpenForReading().
  Status Read(std::uint64_t first, std::size_t count, IntervalRecord* records) const;

private:
  TemporaryRecords(FileSystem& files, std::string path, std::unique_ptr<WritableFile> writer);
  Status Flush();

  FileSystem& Files;
  std::string Path;
  std::unique_ptr<WritableFile> Writer;
  std::unique_ptr<RandomAccessFile> Reader;
  std::vector<IntervalRecord> Buffer;
  std::uint64_t Count = 0;
};

/// Reads a part of a temporary file from front to back through a buffer.
class TemporaryRecordStream
{
public:
  TemporaryRecordStream(const TemporaryRecords& records, std::uint64_t first, std::uint64_t count,
    std::size_t bufferBytes);

  /// The next record; null at the end, or on an error: see `status`.
  const IntervalRecord* Next(Status& status);

private:
  const TemporaryRecords& Records;
  std::uint64_t Position;
  std::uint64_t End;
  std::vector<IntervalRecord> Buffer;
  std::size_t BufferPosition = 0;
  std::size_t BufferEnd = 0;
};

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
