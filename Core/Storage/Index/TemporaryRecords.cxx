// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/TemporaryRecords.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

std::size_t CountRecords(std::size_t bytes)
{
  return std::max<std::size_t>(1, bytes / sizeof(IntervalRecord));
}

} // namespace

Result<std::unique_ptr<TemporaryRecords>> TemporaryRecords::Create(
  TemporaryNames& names, std::size_t bufferBytes)
{
  std::string path = names.Make();
  ISOSURFACE_ASSIGN_OR_RETURN(auto writer, names.Files.CreateForWriting(path));
  std::unique_ptr<TemporaryRecords> records(
    new TemporaryRecords(names.Files, std::move(path), std::move(writer)));
  records->Buffer.reserve(CountRecords(bufferBytes));
  return records;
}

TemporaryRecords::TemporaryRecords(
  FileSystem& files, std::string path, std::unique_ptr<WritableFile> writer)
  : Files(files)
  , Path(std::move(path))
  , Writer(std::move(writer))
{
}

TemporaryRecords::~TemporaryRecords()
{
  this->Writer.reset();
  this->Reader.reset();
  // A destructor cannot report an error; the file's name says that it may be removed.
  static_cast<void>(this->Files.RemoveAll(this->Path));
}

Status TemporaryRecords::Append(const IntervalRecord& record)
{
  if (this->Buffer.size() == this->Buffer.capacity())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Flush());
  }
  this->Buffer.push_back(record);
  ++this->Count;
  return Status::Ok();
}

Status TemporaryRecords::FinishWriting()
{
  ISOSURFACE_RETURN_IF_ERROR(this->Flush());
  std::vector<IntervalRecord>().swap(this->Buffer);
  ISOSURFACE_RETURN_IF_ERROR(this->Writer->SyncAndClose());
  this->Writer.reset();
  return Status::Ok();
}

Status TemporaryRecords::OpenForReading()
{
  ISOSURFACE_ASSIGN_OR_RETURN(this->Reader, this->Files.OpenForReading(this->Path));
  return Status::Ok();
}

Status TemporaryRecords::Flush()
{
  if (!this->Buffer.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->Writer->Append(this->Buffer.data(), this->Buffer.size() * sizeof(IntervalRecord)));
    this->Buffer.clear();
  }
  return Status::Ok();
}

Status TemporaryRecords::Read(std::uint64_t first, std::size_t count, IntervalRecord* records) const
{
  return this->Reader->Read(
    first * sizeof(IntervalRecord), count * sizeof(IntervalRecord), records);
}

TemporaryRecordStream::TemporaryRecordStream(const TemporaryRecords& records, std::uint64_t first,
  std::uint64_t count, std::size_t bufferBytes)
  : Records(records)
  , Position(first)
  , End(first + count)
  , Buffer(static_cast<std::size_t>(
      std::min<std::uint64_t>(std::max<std::uint64_t>(1, count), CountRecords(bufferBytes))))
{
}

const IntervalRecord* TemporaryRecordStream::Next(Status& status)
{
  if (this->BufferPosition == this->BufferEnd)
  {
    const auto count = static_cast<std::size_t>(
      std::min<std::uint64_t>(this->Buffer.size(), this->End - this->Position));
    if (count == 0)
    {
      return nullptr;
    }
    status = this->Records.Read(this->Position, count, this->Buffer.data());
    if (!status.IsOk())
    {
      return nullptr;
    }
    this->Position += count;
    this->BufferPosition = 0;
    this->BufferEnd = count;
  }
  return &this->Buffer[this->BufferPosition++];
}

} // namespace isosurface
