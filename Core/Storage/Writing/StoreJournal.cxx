// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/StoreJournal.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace isosurface
{
namespace
{

using Bytes = std::vector<std::uint8_t>;

/// The entries that are in memory as bytes, too, at a time.
constexpr std::size_t EntriesAtOnce = 4096;

void AppendRange(Bytes& bytes, const KeyRange& range)
{
  AppendLittleEndian<std::uint64_t>(bytes, range.Minimum);
  AppendLittleEndian<std::uint64_t>(bytes, range.Maximum);
}

KeyRange ReadRange(ByteReader& reader)
{
  KeyRange range;
  range.Minimum = reader.Read<std::uint64_t>();
  range.Maximum = reader.Read<std::uint64_t>();
  return range;
}

/// The checksum of entries, each seeded by those before it: so it does not depend on how many are
/// read or written at once.
std::uint64_t ChainChecksums(const Bytes& bytes, std::size_t entryBytes, std::uint64_t before)
{
  for (std::size_t at = 0; at < bytes.size(); at += entryBytes)
  {
    before = ComputeChecksum(bytes.data() + at, entryBytes, before);
  }
  return before;
}

std::size_t GetEntryBytes(std::size_t segments, std::size_t variables)
{
  return sizeof(BlockDirectoryEntry::Block) + sizeof(BlockDirectoryEntry::Offset) +
    segments * sizeof(std::uint32_t) + variables * sizeof(KeyRange);
}

Status ReadWhole(const RandomAccessFile& file, std::uint64_t offset, std::uint64_t size, Bytes& to)
{
  if (offset > file.GetSize() || size > file.GetSize() - offset)
  {
    return Status(StatusCode::Corrupt, file.GetPath() + ": truncated");
  }
  to.resize(static_cast<std::size_t>(size));
  return file.Read(offset, to.size(), to.data());
}

} // namespace

void AppendedSum::Add(const void* bytes, std::size_t size)
{
  this->Sum = ComputeChecksum(bytes, size, this->Sum);
}

Status AppendedSum::Check(
  FileSystem& files, const std::string& path, const std::vector<std::uint64_t>& ends) const
{
  constexpr std::uint64_t bytesAtOnce = std::uint64_t{ 1 } << 20;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  AppendedSum found;
  Bytes bytes;
  std::uint64_t begin = 0;
  for (auto next = ends.begin(); next != ends.end();)
  {
    const auto first = next;
    while (next != ends.end() && (next == first || *next - begin <= bytesAtOnce))
    {
      ++next;
    }
    const std::uint64_t end = *std::prev(next);
    ISOSURFACE_RETURN_IF_ERROR(ReadWhole(*file, begin, end - begin, bytes));
    std::uint64_t portion = begin;
    for (auto at = first; at != next; portion = *at++)
    {
      found.Add(bytes.data() + (portion - begin), static_cast<std::size_t>(*at - portion));
    }
    begin = end;
  }
  return found.Sum == this->Sum ? Status::Ok() : Status(StatusCode::Corrupt, path + ": is damaged");
}

Status StoreJournal::AppendEntries(
  const std::vector<BlockDirectoryEntry>& entries, const std::vector<std::vector<KeyRange>>& ranges)
{
  Bytes bytes;
  while (this->Count < entries.size())
  {
    const std::size_t end = std::min(entries.size(), this->Count + EntriesAtOnce);
    bytes.clear();
    for (std::size_t index = this->Count; index < end; ++index)
    {
      const BlockDirectoryEntry& entry = entries[index];
      AppendLittleEndian(bytes, entry.Block);
      AppendLittleEndian(bytes, entry.Offset);
      for (const std::uint32_t length : entry.Lengths)
      {
        AppendLittleEndian(bytes, length);
      }
      for (const std::vector<KeyRange>& ofVariable : ranges)
      {
        AppendRange(bytes, ofVariable[static_cast<std::size_t>(entry.Block)]);
      }
    }
    const std::size_t entryBytes = GetEntryBytes(entries[0].Lengths.size(), ranges.size());
    this->EntriesChecksum = ChainChecksums(bytes, entryBytes, this->EntriesChecksum);
    ISOSURFACE_RETURN_IF_ERROR(this->Entries->Append(bytes.data(), bytes.size()));
    this->Count = end;
  }
  this->EntriesBytes = this->Entries->GetSize();
  return this->Entries->Sync();
}

Status StoreJournal::Add(std::int64_t number, const StoreCheckpoint& checkpoint,
  const std::vector<BlockDirectoryEntry>& entries, const std::vector<std::vector<KeyRange>>& ranges)
{
  if (!this->Entries)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      this->Entries, this->Files.CreateForWriting(this->GetEntriesPath()));
  }
  ISOSURFACE_RETURN_IF_ERROR(this->AppendEntries(entries, ranges));
  Bytes bytes(sizeof(std::uint64_t));
  for (const std::uint64_t value :
    { checkpoint.BlocksBytes, checkpoint.BlocksChecksum, checkpoint.BlocksSum,
      checkpoint.OverviewBytes, checkpoint.OverviewSum, this->EntriesBytes, this->EntriesChecksum })
  {
    AppendLittleEndian(bytes, value);
  }
  for (const KeyRange& range : checkpoint.FiniteRanges)
  {
    AppendRange(bytes, range);
  }
  bytes.insert(bytes.end(), checkpoint.Spectra.begin(), checkpoint.Spectra.end());
  StoreLittleEndian(bytes.data(),
    ComputeChecksum(bytes.data() + sizeof(std::uint64_t), bytes.size() - sizeof(std::uint64_t),
      static_cast<std::uint64_t>(number)));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto file, this->Files.CreateForWriting(GetCheckpointPath(this->Folder, number)));
  ISOSURFACE_RETURN_IF_ERROR(file->Append(bytes.data(), bytes.size()));
  ISOSURFACE_RETURN_IF_ERROR(file->SyncAndClose());
  return this->Files.SyncDirectory(this->Folder);
}

Result<StoreCheckpoint> StoreJournal::Take(std::int64_t number, std::size_t segments,
  std::vector<BlockDirectoryEntry>& entries, std::vector<std::vector<KeyRange>>& ranges)
{
  const std::string path = GetCheckpointPath(this->Folder, number);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, this->Files.OpenForReading(path));
  Bytes bytes;
  ISOSURFACE_RETURN_IF_ERROR(ReadWhole(*file, 0, file->GetSize(), bytes));
  ByteReader reader(bytes);
  const auto checksum = reader.Read<std::uint64_t>();
  const std::size_t size = reader.GetRemaining();
  if (checksum !=
    ComputeChecksum(bytes.data() + bytes.size() - size, size, static_cast<std::uint64_t>(number)))
  {
    return Status(StatusCode::Corrupt, path + ": is not checkpoint " + std::to_string(number));
  }
  StoreCheckpoint checkpoint;
  checkpoint.BlocksBytes = reader.Read<std::uint64_t>();
  checkpoint.BlocksChecksum = reader.Read<std::uint64_t>();
  checkpoint.BlocksSum = reader.Read<std::uint64_t>();
  checkpoint.OverviewBytes = reader.Read<std::uint64_t>();
  checkpoint.OverviewSum = reader.Read<std::uint64_t>();
  this->EntriesBytes = reader.Read<std::uint64_t>();
  const auto entriesChecksum = reader.Read<std::uint64_t>();
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    checkpoint.FiniteRanges.push_back(ReadRange(reader));
  }
  checkpoint.Spectra.resize(reader.GetRemaining());
  reader.ReadAll(checkpoint.Spectra);
  ISOSURFACE_RETURN_IF_ERROR(this->ReadEntries(segments, entries, ranges));
  if (this->EntriesChecksum != entriesChecksum)
  {
    return Status(StatusCode::Corrupt, this->GetEntriesPath() + ": is damaged");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    this->Entries, this->Files.OpenForAppending(this->GetEntriesPath(), this->EntriesBytes));
  this->Count = entries.size();
  return checkpoint;
}

Status StoreJournal::ReadEntries(std::size_t segments, std::vector<BlockDirectoryEntry>& entries,
  std::vector<std::vector<KeyRange>>& ranges)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, this->Files.OpenForReading(this->GetEntriesPath()));
  const std::size_t entryBytes = GetEntryBytes(segments, ranges.size());
  const Status corrupt(StatusCode::Corrupt, this->GetEntriesPath() + ": is damaged");
  if (this->EntriesBytes % entryBytes != 0)
  {
    return corrupt;
  }
  Bytes bytes;
  for (std::uint64_t offset = 0; offset < this->EntriesBytes; offset += bytes.size())
  {
    ISOSURFACE_RETURN_IF_ERROR(ReadWhole(
      *file, offset, std::min(this->EntriesBytes - offset, EntriesAtOnce * entryBytes), bytes));
    this->EntriesChecksum = ChainChecksums(bytes, entryBytes, this->EntriesChecksum);
    ByteReader reader(bytes);
    while (reader.GetRemaining() > 0)
    {
      BlockDirectoryEntry entry;
      entry.Block = reader.Read<std::int64_t>();
      entry.Offset = reader.Read<std::uint64_t>();
      entry.Lengths.resize(segments);
      reader.ReadAll(entry.Lengths);
      for (std::vector<KeyRange>& ofVariable : ranges)
      {
        const auto block = static_cast<std::size_t>(entry.Block);
        if (block >= ofVariable.size())
        {
          return corrupt;
        }
        ofVariable[block] = ReadRange(reader);
      }
      entries.push_back(std::move(entry));
    }
  }
  return Status::Ok();
}

Status StoreJournal::Remove(FileSystem& files, const std::string& folder)
{
  for (const std::string& path :
    { folder + "/entries.tmp", GetCheckpointPath(folder, 0), GetCheckpointPath(folder, 1) })
  {
    ISOSURFACE_RETURN_IF_ERROR(files.RemoveAll(path));
  }
  return Status::Ok();
}

} // namespace isosurface
