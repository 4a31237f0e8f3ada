// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalSorter.h"

#include <algorithm>
#include <tuple>
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
namespace
{

// The buffer through which a run is merged, so that reads do not become too small.
constexpr std::size_t MinimumBufferBytes = 8 * 1024;
// With more runs, a second pass costs less than the seeks of a single pass.
constexpr std::size_t MaximumRuns = 128;

} // namespace

/// Merges several runs through buffers of `bytes` bytes in all.
class IntervalSorter::Merge
{
public:
  Merge(const IntervalSorter& sorter, std::size_t runs, std::size_t bytes)
    : Sorter(sorter)
  {
    this->Streams.reserve(runs);
    for (std::size_t run = 0; run < runs; ++run)
    {
      const TemporaryRecords& records = *sorter.Runs[run];
      this->Streams.emplace_back(records, 0, records.GetCount(), bytes / runs);
    }
  }

  const IntervalRecord* Next(Status& status)
  {
    if (!this->Started)
    {
      this->Started = true;
      for (std::size_t run = 0; run < this->Streams.size() && status.IsOk(); ++run)
      {
        status = this->Sorter.Runs[run]->OpenForReading();
        if (status.IsOk())
        {
          this->Advance(run, status);
        }
      }
    }
    else if (!this->Heap.empty())
    {
      // The record returned last is in its stream's buffer, so the stream could not advance before.
      std::pop_heap(this->Heap.begin(), this->Heap.end(), HeapOrder{ this->Sorter });
      const std::size_t run = this->Heap.back().Run;
      this->Heap.pop_back();
      this->Advance(run, status);
    }
    return status.IsOk() && !this->Heap.empty() ? this->Heap.front().Record : nullptr;
  }

private:
  struct Head
  {
    const IntervalRecord* Record;
    std::size_t Run;
  };

  /// Reversed, since the heaps of the standard library have the maximum in front.
  struct HeapOrder
  {
    const IntervalSorter& Sorter;
    bool operator()(const Head& a, const Head& b) const
    {
      return this->Sorter.IsBefore(*b.Record, *a.Record);
    }
  };

  void Advance(std::size_t run, Status& status)
  {
    if (const IntervalRecord* record = this->Streams[run].Next(status))
    {
      this->Heap.push_back({ record, run });
      std::push_heap(this->Heap.begin(), this->Heap.end(), HeapOrder{ this->Sorter });
    }
  }

  const IntervalSorter& Sorter;
  std::vector<TemporaryRecordStream> Streams;
  std::vector<Head> Heap;
  bool Started = false;
};

IntervalSorter::IntervalSorter(TemporaryNames& names, std::size_t memoryBytes, Order order)
  : Names(names)
  , MemoryBytes(memoryBytes)
  , RecordOrder(order)
{
}

IntervalSorter::~IntervalSorter() = default;

std::size_t IntervalSorter::GetMemoryRecords(std::size_t memoryBytes)
{
  // The vector last grows from at most a quarter of its final capacity: 5/4 of it exist then.
  return std::max<std::size_t>(4, memoryBytes / 5 * 4 / sizeof(IntervalRecord));
}

Status IntervalSorter::Add(const IntervalRecord& record)
{
  if (this->Records.size() == this->Records.capacity())
  {
    const std::size_t maximum = GetMemoryRecords(this->MemoryBytes);
    if (this->Records.size() >= maximum)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->WriteRun());
    }
    else
    {
      const std::size_t twice = std::max<std::size_t>(64, 2 * this->Records.capacity());
      this->Records.reserve(twice > maximum / 4 ? maximum : twice);
    }
  }
  this->Records.push_back(record);
  ++this->Count;
  return Status::Ok();
}

Status IntervalSorter::Sort()
{
  if (this->Runs.empty())
  {
    this->SortMemory();
    return Status::Ok();
  }
  if (!this->Records.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->WriteRun());
  }
  std::vector<IntervalRecord>().swap(this->Records);
  // One buffer is for the merged run.
  const std::size_t maximum =
    std::clamp<std::size_t>(this->MemoryBytes / MinimumBufferBytes, 3, MaximumRuns + 1) - 1;
  while (this->Runs.size() > maximum)
  {
    // The first merge takes as many runs as are needed for all later merges to be full.
    const std::size_t excess = (this->Runs.size() - 1) % (maximum - 1);
    ISOSURFACE_RETURN_IF_ERROR(this->MergeFirstRuns(excess == 0 ? maximum : excess + 1));
  }
  this->FinalMerge = std::make_unique<Merge>(*this, this->Runs.size(), this->MemoryBytes);
  return Status::Ok();
}

const IntervalRecord* IntervalSorter::Next(Status& status)
{
  if (this->FinalMerge)
  {
    return this->FinalMerge->Next(status);
  }
  return this->Position < this->Records.size() ? &this->Records[this->Position++] : nullptr;
}

bool IntervalSorter::IsBefore(const IntervalRecord& a, const IntervalRecord& b) const
{
  if (this->RecordOrder == Order::AscendingMinimum)
  {
    return std::tie(a.Group, a.Minimum, a.Maximum, a.Payload) <
      std::tie(b.Group, b.Minimum, b.Maximum, b.Payload);
  }
  return std::tie(a.Group, b.Maximum, a.Minimum, a.Payload) <
    std::tie(b.Group, a.Maximum, b.Minimum, b.Payload);
}

void IntervalSorter::SortMemory()
{
  std::sort(this->Records.begin(), this->Records.end(),
    [this](const IntervalRecord& a, const IntervalRecord& b) { return this->IsBefore(a, b); });
}

Status IntervalSorter::WriteRun()
{
  this->SortMemory();
  ISOSURFACE_ASSIGN_OR_RETURN(auto run, TemporaryRecords::Create(this->Names, MinimumBufferBytes));
  for (const IntervalRecord& record : this->Records)
  {
    ISOSURFACE_RETURN_IF_ERROR(run->Append(record));
  }
  ISOSURFACE_RETURN_IF_ERROR(run->FinishWriting());
  this->Runs.push_back(std::move(run));
  this->Records.clear();
  return Status::Ok();
}

Status IntervalSorter::MergeFirstRuns(std::size_t count)
{
  const std::size_t buffer = this->MemoryBytes / (count + 1);
  ISOSURFACE_ASSIGN_OR_RETURN(auto run, TemporaryRecords::Create(this->Names, buffer));
  {
    Merge merge(*this, count, buffer * count);
    Status status;
    while (const IntervalRecord* record = merge.Next(status))
    {
      ISOSURFACE_RETURN_IF_ERROR(run->Append(*record));
    }
    ISOSURFACE_RETURN_IF_ERROR(status);
  }
  ISOSURFACE_RETURN_IF_ERROR(run->FinishWriting());
  this->Runs.erase(this->Runs.begin(), this->Runs.begin() + static_cast<std::ptrdiff_t>(count));
  this->Runs.push_back(std::move(run));
  return Status::Ok();
}

} // namespace isosurface
