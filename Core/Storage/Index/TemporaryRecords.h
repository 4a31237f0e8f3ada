// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TemporaryRecords_h
#define isosurface_TemporaryRecords_h

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

} // namespace isosurface

#endif
