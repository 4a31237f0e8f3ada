// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Verification/MergedStore.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Base/PagedFile.h"
#include "Ground/Base/ParallelFor.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/BlockStore.h"
#include "Storage/Verification/StoreVerification.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace isosurface
{
namespace
{

using FileList = std::vector<std::unique_ptr<RandomAccessFile>>;

Status MakeReadOnlyError(const std::string& path)
{
  return Status(StatusCode::Unsupported, path + ": is only read");
}

/// Bytes of one file or another.
class MergedFile : public RandomAccessFile
{
public:
  MergedFile(FileList files, std::string path, std::uint64_t size)
    : Sources(std::move(files))
    , Path(std::move(path))
    , Size(size)
  {
  }

  std::uint64_t GetSize() const override { return this->Size; }
  const std::string& GetPath() const override { return this->Path; }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    if (offset > this->Size || size > this->Size - offset)
    {
      return Status(StatusCode::Corrupt, this->Path + ": truncated");
    }
    auto* to = static_cast<std::uint8_t*>(bytes);
    while (size > 0)
    {
      std::uint64_t end = this->Size;
      const std::size_t source = this->FindSource(offset, end);
      const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(size, end - offset));
      ISOSURFACE_RETURN_IF_ERROR(this->Sources[source]->Read(offset, part, to));
      offset += part;
      to += part;
      size -= part;
    }
    return Status::Ok();
  }

protected:
  /// The file that has the bytes from an offset on, and where they end.
  virtual std::size_t FindSource(std::uint64_t offset, std::uint64_t& end) const = 0;

  FileList Sources;

private:
  std::string Path;
  std::uint64_t Size;
};

std::size_t FindFirstFile(const FileList& files)
{
  const auto first =
    std::find_if(files.begin(), files.end(), [](const auto& file) { return file != nullptr; });
  return static_cast<std::size_t>(first - files.begin());
}

bool ReadPage(const RandomAccessFile& file, std::uint64_t page, std::vector<std::uint8_t>& bytes)
{
  const std::size_t payload = bytes.size() - PagedFile::ChecksumSize;
  return file.GetSize() >= (page + 1) * bytes.size() &&
    file.Read(page * bytes.size(), bytes.size(), bytes.data()).IsOk() &&
    LoadLittleEndian<std::uint64_t>(bytes.data() + payload) ==
    ComputeChecksum(bytes.data(), payload, page);
}

class MergedPages : public MergedFile
{
public:
  MergedPages(FileList files, const std::string& path, std::size_t pageSize, std::uint64_t size)
    : MergedFile(std::move(files), path, size)
    , PageSize(pageSize)
  {
  }

protected:
  std::size_t FindSource(std::uint64_t offset, std::uint64_t& end) const override
  {
    const std::uint64_t page = offset / this->PageSize;
    end = (page + 1) * this->PageSize;
    std::vector<std::uint8_t> bytes(this->PageSize);
    std::size_t source = 0;
    while (source < this->Sources.size() &&
      !(this->Sources[source] && ReadPage(*this->Sources[source], page, bytes)))
    {
      ++source;
    }
    return source < this->Sources.size() ? source : FindFirstFile(this->Sources);
  }

private:
  std::size_t PageSize;
};

class MergedRecords : public MergedFile
{
public:
  /// Where a record ends, and which file has it.
  struct Record
  {
    std::uint64_t End;
    std::size_t Source;
  };

  MergedRecords(
    FileList files, const std::string& path, std::uint64_t size, std::vector<Record> records)
    : MergedFile(std::move(files), path, size)
    , Records(std::move(records))
  {
  }

protected:
  std::size_t FindSource(std::uint64_t offset, std::uint64_t& end) const override
  {
    const auto record = std::upper_bound(this->Records.begin(), this->Records.end(), offset,
      [](std::uint64_t at, const Record& other) { return at < other.End; });
    if (record == this->Records.end())
    {
      return FindFirstFile(this->Sources);
    }
    end = record->End;
    return record->Source;
  }

private:
  std::vector<Record> Records;
};

} // namespace

MergedStore::MergedStore(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, std::vector<std::string> folders)
  : Disk(files)
  , Description(step.Stores[store])
  , Variables(header.GetVariables())
  , Grid(header.GetBlockGrid())
  , Segments(Variables.GetNumberOfStored() * static_cast<std::size_t>(Grid.GetNumberOfLevels()))
  , Place(step.Source ? SamplePlace::Source : SamplePlace::Store)
  , Folders(std::move(folders))
{
}

std::vector<std::string> MergedStore::ListNames() const
{
  std::vector<std::string> names;
  for (const std::string& path : BlockStore::ListPaths(this->Folders.front(), this->Variables))
  {
    names.push_back(path.substr(this->Folders.front().size()));
  }
  return names;
}

MergedStore::Files MergedStore::OpenAll(const std::string& name) const
{
  Files files;
  for (const std::string& folder : this->Folders)
  {
    auto file = this->Disk.OpenForReading(folder + name);
    files.push_back(file.IsOk() ? std::move(*file) : nullptr);
  }
  return files;
}

Result<std::unique_ptr<RandomAccessFile>> MergedStore::OpenPages(const std::string& name) const
{
  const std::string path = this->Folders.front() + name;
  Files files = this->OpenAll(name);
  std::uint64_t longest = 0;
  for (const auto& file : files)
  {
    longest = std::max(longest, file ? file->GetSize() : 0);
  }
  for (const std::size_t size : { std::size_t{ 4096 }, std::size_t{ 8192 }, std::size_t{ 16384 } })
  {
    std::vector<std::uint8_t> page(size);
    for (const auto& file : files)
    {
      if (file && ReadPage(*file, 0, page) &&
        LoadLittleEndian<std::uint32_t>(page.data() + 12) == size)
      {
        const std::uint64_t pages =
          std::min(LoadLittleEndian<std::uint64_t>(page.data() + 16), longest / size);
        return std::unique_ptr<RandomAccessFile>(
          new MergedPages(std::move(files), path, size, pages * size));
      }
    }
  }
  return Status(StatusCode::Corrupt, path + ": no replica has its first page");
}

std::uint64_t MergedStore::GetRecordSize(const BlockDirectoryEntry& entry) const
{
  return this->Place == SamplePlace::Source
    ? this->Segments * BlockRecord::SegmentHeaderSize
    : BlockRecord::AlignUp(entry.FindSegment(this->Segments));
}

bool MergedStore::IsIntact(const RandomAccessFile& file, const BlockDirectoryEntry& entry) const
{
  const std::uint64_t size = this->GetRecordSize(entry);
  const std::uint64_t length = file.GetSize();
  if (size > this->Description.Bytes || entry.Offset > length || size > length - entry.Offset)
  {
    return false;
  }
  std::vector<std::uint8_t> record(static_cast<std::size_t>(size));
  if (!file.Read(entry.Offset, record.size(), record.data()).IsOk())
  {
    return false;
  }
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  for (std::size_t segment = 0; segment < this->Segments; ++segment)
  {
    if (this->Place == SamplePlace::Source)
    {
      std::array<std::uint8_t, 8> stated{};
      StoreLittleEndian(stated.data(), entry.Lengths[segment]);
      if (std::memcmp(record.data() + segment * BlockRecord::SegmentHeaderSize + 8, stated.data(),
            stated.size()) != 0)
      {
        return false;
      }
      continue;
    }
    const SegmentPlace place = { entry.Block, static_cast<std::uint32_t>(segment / levels),
      static_cast<std::uint32_t>(levels - 1 - segment % levels) };
    if (!CheckSegment(record.data() + entry.FindSegment(segment), entry.Lengths[segment], place)
           .IsOk())
    {
      return false;
    }
  }
  const std::uint64_t end =
    this->Place == SamplePlace::Source ? size : entry.FindSegment(this->Segments);
  return std::all_of(record.begin() + static_cast<std::ptrdiff_t>(end), record.end(),
    [](std::uint8_t byte) { return byte == 0; });
}

template <typename Visit>
Status MergedStore::VisitEntries(const Visit& visit)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto directory,
    BlockStore::OpenDirectory(
      *this, this->Folders.front(), this->Description, this->Segments, this->Place));
  QueryStatistics statistics;
  for (std::uint64_t ordinal = 0; ordinal < this->Description.Blocks; ++ordinal)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto entry,
      directory->Read(
        ordinal, this->Grid.GetNumberOfBlocks(), this->Description.Bytes, statistics));
    visit(entry);
  }
  return Status::Ok();
}

std::size_t MergedStore::FindIntactFile(const Files& files, const BlockDirectoryEntry& entry) const
{
  const auto intact = std::find_if(files.begin(), files.end(),
    [&](const auto& file) { return file && this->IsIntact(*file, entry); });
  return static_cast<std::size_t>(intact - files.begin());
}

Result<std::vector<std::int64_t>> MergedStore::FindLostBlocks()
{
  const Files files = this->OpenAll("/blocks");
  std::vector<std::int64_t> lost;
  ISOSURFACE_RETURN_IF_ERROR(this->VisitEntries(
    [&](const BlockDirectoryEntry& entry)
    {
      if (this->FindIntactFile(files, entry) == files.size())
      {
        lost.push_back(entry.Block);
      }
    }));
  std::sort(lost.begin(), lost.end());
  return lost;
}

Result<std::unique_ptr<RandomAccessFile>> MergedStore::OpenRecords()
{
  Files files = this->OpenAll("/blocks");
  const std::string path = StoreRecords::GetPath(this->Folders.front());
  const std::size_t first = FindFirstFile(files);
  if (first == files.size())
  {
    return Status(StatusCode::NotFound, path + ": no replica has the file");
  }
  std::vector<MergedRecords::Record> records;
  ISOSURFACE_RETURN_IF_ERROR(this->VisitEntries(
    [&](const BlockDirectoryEntry& entry)
    {
      const std::size_t intact = this->FindIntactFile(files, entry);
      records.push_back(
        { entry.Offset + this->GetRecordSize(entry), intact < files.size() ? intact : first });
    }));
  std::sort(
    records.begin(), records.end(), [](const auto& a, const auto& b) { return a.End < b.End; });
  return std::unique_ptr<RandomAccessFile>(
    new MergedRecords(std::move(files), path, this->Description.Bytes, std::move(records)));
}

Result<std::unique_ptr<RandomAccessFile>> MergedStore::OpenForReading(const std::string& path)
{
  const std::string& folder = this->Folders.front();
  if (path == StoreRecords::GetPath(folder))
  {
    return this->OpenRecords();
  }
  return this->OpenPages(path.substr(std::min(path.size(), folder.size())));
}

bool MergedStore::Exists(const std::string& path)
{
  return path == this->Folders.front();
}

Result<std::unique_ptr<WritableFile>> MergedStore::CreateForWriting(const std::string& path)
{
  return MakeReadOnlyError(path);
}

Status MergedStore::Rename(const std::string& from, const std::string&)
{
  return MakeReadOnlyError(from);
}

Status MergedStore::MakeDirectories(const std::string& path)
{
  return MakeReadOnlyError(path);
}

Status MergedStore::RemoveAll(const std::string& path)
{
  return MakeReadOnlyError(path);
}

Result<std::vector<std::string>> MergedStore::List(const std::string&)
{
  return std::vector<std::string>();
}

Status MergedStore::SyncDirectory(const std::string& path)
{
  return MakeReadOnlyError(path);
}

std::vector<Status> CheckStore(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::string& folder, int threads)
{
  const ArrayVariables variables = header.GetVariables();
  const BlockGrid grid = header.GetBlockGrid();
  StoreVerification check(files, variables, grid, step.Stores[store], folder,
    step.Source ? SamplePlace::Source : SamplePlace::Store, nullptr);
  check.Open();
  ParallelFor(static_cast<std::size_t>(check.GetNumberOfRuns()), threads,
    [&](std::size_t run, int) { check.CheckRun(run); });
  std::vector<std::uint8_t> unused;
  check.Finish(unused);
  return check.TakeFaults();
}

Status CheckReplicas(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::vector<std::string>& folders,
  int threads)
{
  MergedStore merged(files, header, step, store, folders);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto lost, merged.FindLostBlocks());
  if (!lost.empty())
  {
    constexpr std::size_t listed = 100;
    std::string blocks;
    for (std::size_t index = 0; index < std::min(listed, lost.size()); ++index)
    {
      blocks += (index == 0 ? "" : ", ") + std::to_string(lost[index]);
    }
    if (lost.size() > listed)
    {
      blocks += " and " + std::to_string(lost.size() - listed) + " more";
    }
    return Status(StatusCode::Corrupt,
      folders.front() + ": no replica has " + (lost.size() == 1 ? "block " : "the blocks ") +
        blocks);
  }
  const std::vector<Status> faults =
    CheckStore(merged, header, step, store, folders.front(), threads);
  return faults.empty() ? Status::Ok() : faults.front();
}

} // namespace isosurface
