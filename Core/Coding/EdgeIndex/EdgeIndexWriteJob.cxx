// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/WithinMemory.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t BlocksPerThread = 64;
constexpr std::size_t MaximumOutputBytes = std::size_t{ 4 } << 20;
constexpr std::int64_t EndOfNumbers = std::numeric_limits<std::int64_t>::max();

// Runs a step of this rank. Collective.
template <typename Step>
Status AgreeWithinMemory(Communicator& ranks, const std::string& path, const Step& step)
{
  return ranks.Agree(RunWithinMemory(path,
    ": there is not enough memory to write the isosurface; a lower MemoryLimit or fewer "
    "threads take less.",
    step));
}

} // namespace

struct EdgeIndexWriteJob::RoundBlock
{
  std::int64_t Number = 0;
  int Rank = 0;
  std::vector<EdgeIndexEntry> Records; ///< without offsets
};

EdgeIndexWriteJob::EdgeIndexWriteJob(Communicator& ranks, FileSystem& files, std::string path,
  const EdgeIndexHeader& header, BlockSource& source, const std::vector<std::int64_t>& numbers,
  const Settings& settings)
  : Ranks(ranks)
  , Files(files)
  , Path(std::move(path))
  , Header(header)
  , Source(source)
  , Numbers(numbers)
  , Wanted(settings)
  , Encoders(static_cast<std::size_t>(std::max(1, settings.Threads)))
{
}

Result<EdgeIndexFileSummary> EdgeIndexWriteJob::Run(const Progress& progress)
{
  const Status status = RunCollective(this->Path,
    [&]() -> Status
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Begin());
      ISOSURFACE_RETURN_IF_ERROR(this->WriteRounds(progress));
      return this->Finish();
    });
  if (!status.IsOk())
  {
    this->File.reset();
    if (this->Lock)
    {
      // Ours. If it cannot be removed, it is not taken for a complete one all the same.
      static_cast<void>(this->Files.RemoveAll(GetPartialEdgeIndexPath(this->Path)));
      this->Lock.reset();
    }
    return status;
  }
  return this->Summary;
}

// Rank 0 creates the file, then the others open it.
Status EdgeIndexWriteJob::Begin()
{
  this->Header.NumberOfBlocks = this->Ranks.Sum(this->Numbers.size());
  this->Header.Append(this->HeaderBytes);
  this->Offset = this->HeaderBytes.size();
  const std::string partial = GetPartialEdgeIndexPath(this->Path);
  const bool isFirst = this->Ranks.GetRank() == 0;
  const auto open = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Header.Check());
    if (isFirst)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(this->Lock, LockEdgeIndexFile(this->Files, this->Path));
    }
    ISOSURFACE_ASSIGN_OR_RETURN(this->File,
      isFirst ? this->Files.CreateForWriting(partial) : this->Files.OpenForUpdate(partial));
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(isFirst ? open() : Status::Ok()));
  return this->Ranks.Agree(isFirst ? Status::Ok() : open());
}

Status EdgeIndexWriteJob::WriteRounds(const Progress& progress)
{
  std::int64_t end = 0;
  while (end != EndOfNumbers)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      AgreeWithinMemory(this->Ranks, this->Path, [&] { return this->EncodeAhead(progress); }));
    if (end == 0)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->WriteHeader());
    }
    const bool isDone = this->NextBlock == this->Numbers.size();
    const std::uint64_t next = this->Ranks.Minimum(
      static_cast<std::uint64_t>(isDone ? EndOfNumbers : this->Numbers[this->NextBlock]));
    end = static_cast<std::int64_t>(next);
    ISOSURFACE_RETURN_IF_ERROR(this->WriteRound(end));
  }
  return Status::Ok();
}

// Once the first blocks are encoded, which tell how large the file will be.
Status EdgeIndexWriteJob::WriteHeader()
{
  std::vector<std::uint64_t> encoded = { this->PendingBytes, this->NextBlock };
  this->Ranks.ReduceSum(encoded);
  const auto write = [&]() -> Status
  {
    const double blocks = static_cast<double>(std::max<std::uint64_t>(1, encoded[1]));
    const double share = static_cast<double>(this->Header.NumberOfBlocks) / blocks;
    const auto bytes = static_cast<std::uint64_t>(static_cast<double>(encoded[0]) * share);
    const std::string warning =
      DescribeLackOfRoom(this->Files, this->Path, this->HeaderBytes.size() + bytes, "about");
    if (!warning.empty() && this->Wanted.Warn)
    {
      this->Wanted.Warn(warning);
    }
    return this->File->WriteAt(0, this->HeaderBytes.data(), this->HeaderBytes.size());
  };
  const bool isFirst = this->Ranks.GetRank() == 0;
  return AgreeWithinMemory(
    this->Ranks, this->Path, [&] { return isFirst ? write() : Status::Ok(); });
}

Status EdgeIndexWriteJob::EncodeAhead(const Progress& progress)
{
  const std::size_t count = this->Numbers.size();
  while (this->NextBlock < count && this->PendingBytes < this->Wanted.MemoryBytes)
  {
    const std::size_t size =
      std::min(BlocksPerThread * this->Encoders.size(), count - this->NextBlock);
    const auto all = static_cast<double>(count);
    ISOSURFACE_RETURN_IF_ERROR(this->EncodeBatch(size,
      MakePartOfProgress(progress, static_cast<double>(this->NextBlock) / all,
        static_cast<double>(this->NextBlock + size) / all)));
    this->NextBlock += size;
  }
  return Status::Ok();
}

Status EdgeIndexWriteJob::EncodeBatch(std::size_t size, const Progress& progress)
{
  std::vector<PendingBlock> blocks(size);
  const auto encode = [&](std::size_t n, std::unique_ptr<EdgeIndexEncoder>& encoder) -> Status
  {
    if (!encoder)
    {
      encoder = std::make_unique<EdgeIndexEncoder>(this->Header);
    }
    const std::size_t block = this->NextBlock + n;
    ISOSURFACE_ASSIGN_OR_RETURN(const BlockSamples samples, this->Source.Acquire(block));
    blocks[n].Number = this->Numbers[block];
    for (std::size_t isovalue = 0; isovalue < this->Header.Isovalues.size(); ++isovalue)
    {
      ISOSURFACE_RETURN_IF_ERROR(encoder->EncodeBlock(
        this->Source.GetLatticeCoordinates(block), samples, isovalue, blocks[n].Bytes));
    }
    return Status::Ok();
  };
  FirstFailure failure;
  const bool finished = ParallelFor(
    size, static_cast<int>(this->Encoders.size()),
    [&](std::size_t n, int thread)
    { failure.Run([&] { return encode(n, this->Encoders[static_cast<std::size_t>(thread)]); }); },
    progress);
  ISOSURFACE_RETURN_IF_ERROR(failure.Get());
  if (!finished)
  {
    return { StatusCode::Aborted, this->Path + ": writing was aborted." };
  }
  for (PendingBlock& block : blocks)
  {
    if (!block.Bytes.empty())
    {
      block.Bytes.shrink_to_fit();
      this->PendingBytes += block.Bytes.size();
      this->Pending.push_back(std::move(block));
    }
  }
  return Status::Ok();
}

// For each own block before `end`: its number, the number of its records, and for each record its size
// and EdgeIndexBlock, as in the directory.
Message EdgeIndexWriteJob::DescribeBlocks(std::int64_t end) const
{
  Message message;
  for (const PendingBlock& pending : this->Pending)
  {
    if (pending.Number >= end)
    {
      break;
    }
    Message records;
    std::uint64_t count = 0;
    std::size_t used = 0;
    for (std::size_t at = 0; at < pending.Bytes.size(); at += used, ++count)
    {
      const auto record = EdgeIndexRecord::Parse(
        this->Header, pending.Bytes.data() + at, pending.Bytes.size() - at, used);
      AppendVarint(records, used);
      record->Block.Append(records);
    }
    AppendVarint(message, static_cast<std::uint64_t>(pending.Number));
    AppendVarint(message, count);
    message.insert(message.end(), records.begin(), records.end());
  }
  return message;
}

Status EdgeIndexWriteJob::ParseBlocks(
  const Message& message, int rank, std::vector<RoundBlock>& blocks) const
{
  ByteReader reader(message);
  while (reader.GetRemaining() > 0)
  {
    RoundBlock block;
    block.Rank = rank;
    block.Number = reader.ReadVarint<std::int64_t>();
    const auto count = reader.ReadVarint();
    for (std::uint64_t n = 0; n < count && !reader.HasFailed(); ++n)
    {
      EdgeIndexEntry& entry = block.Records.emplace_back();
      entry.Size = reader.ReadVarint();
      ISOSURFACE_ASSIGN_OR_RETURN(entry.Block, EdgeIndexBlock::Parse(this->Header, reader));
    }
    blocks.push_back(std::move(block));
  }
  return Status::Ok();
}

Status EdgeIndexWriteJob::WriteRound(std::int64_t end)
{
  Message mine;
  const auto describe = [&]
  {
    mine = this->DescribeBlocks(end);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AgreeWithinMemory(this->Ranks, this->Path, describe));
  const std::vector<Message> messages = this->Ranks.AllGather(mine);
  const auto write = [&]() -> Status
  {
    std::vector<RoundBlock> blocks;
    for (std::size_t rank = 0; rank < messages.size(); ++rank)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ParseBlocks(messages[rank], static_cast<int>(rank), blocks));
    }
    std::sort(blocks.begin(), blocks.end(),
      [](const RoundBlock& a, const RoundBlock& b) { return a.Number < b.Number; });
    for (const RoundBlock& block : blocks)
    {
      const bool isOwn = block.Rank == this->Ranks.GetRank();
      ISOSURFACE_RETURN_IF_ERROR(
        this->PlaceBlock(block, isOwn ? this->Pending.front().Bytes.data() : nullptr));
      if (isOwn)
      {
        this->PendingBytes -= this->Pending.front().Bytes.size();
        this->Pending.pop_front();
      }
    }
    return this->FlushOutput();
  };
  return AgreeWithinMemory(this->Ranks, this->Path, write);
}

// Takes records as they stand in the file, but writes only the own ones.
Status EdgeIndexWriteJob::PlaceBlock(const RoundBlock& block, const std::uint8_t* bytes)
{
  for (const EdgeIndexEntry& record : block.Records)
  {
    const auto size = static_cast<std::size_t>(record.Size);
    if (!record.Block.IsPreview)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Place(record, bytes, size));
      ++this->Summary.Records;
      this->Summary.Points += record.Block.NumberOfPoints;
    }
    else
    {
      this->Previews.push_back(record);
      this->OwnPreviews.emplace_back(bytes, bytes ? bytes + size : nullptr);
      this->PreviewBytes += record.Size;
    }
    bytes = bytes ? bytes + size : nullptr;
    if (this->PreviewBytes >= MaximumEdgeIndexPreviewBytes)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->FlushPreview());
    }
  }
  return Status::Ok();
}

Status EdgeIndexWriteJob::FlushPreview()
{
  for (std::size_t n = 0; n < this->Previews.size(); ++n)
  {
    const std::vector<std::uint8_t>& own = this->OwnPreviews[n];
    ISOSURFACE_RETURN_IF_ERROR(
      this->Place(this->Previews[n], own.empty() ? nullptr : own.data(), own.size()));
  }
  this->Previews.clear();
  this->OwnPreviews.clear();
  this->PreviewBytes = 0;
  return Status::Ok();
}

// Assigns the next offset in the file to a record, and writes it if `bytes` is not null.
Status EdgeIndexWriteJob::Place(
  const EdgeIndexEntry& entry, const std::uint8_t* bytes, std::size_t size)
{
  if (this->Ranks.GetRank() == 0)
  {
    this->Entries.push_back(entry);
  }
  const std::uint64_t offset = this->Offset;
  this->Offset += entry.Size;
  if (!bytes)
  {
    return Status::Ok();
  }
  if (offset != this->OutputOffset + this->Output.size() ||
    this->Output.size() >= MaximumOutputBytes)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->FlushOutput());
    this->OutputOffset = offset;
  }
  this->Output.insert(this->Output.end(), bytes, bytes + size);
  return Status::Ok();
}

Status EdgeIndexWriteJob::FlushOutput()
{
  if (!this->Output.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->File->WriteAt(this->OutputOffset, this->Output.data(), this->Output.size()));
    this->OutputOffset += this->Output.size();
    this->Output.clear();
  }
  return Status::Ok();
}

Status EdgeIndexWriteJob::Finish()
{
  const bool isFirst = this->Ranks.GetRank() == 0;
  const auto complete = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(this->FlushPreview());
    ISOSURFACE_RETURN_IF_ERROR(this->FlushOutput());
    if (isFirst)
    {
      std::vector<std::uint8_t> end;
      EdgeIndexDirectory::Append(this->Entries, this->HeaderBytes, end);
      ISOSURFACE_RETURN_IF_ERROR(this->File->WriteAt(this->Offset, end.data(), end.size()));
      this->Summary.Bytes = this->Offset + end.size();
    }
    return this->File->SyncAndClose();
  };
  ISOSURFACE_RETURN_IF_ERROR(AgreeWithinMemory(this->Ranks, this->Path, complete));
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(
    isFirst ? PutEdgeIndexFileInPlace(this->Files, this->Path, this->Lock) : Status::Ok()));
  this->Summary.Bytes = this->Ranks.Maximum(this->Summary.Bytes);
  return Status::Ok();
}

Result<std::unique_ptr<PathLock>> LockEdgeIndexFile(FileSystem& files, const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(files.CheckRegular(path, "write"));
  return files.LockFile(GetPartialEdgeIndexPath(path));
}

Status PutEdgeIndexFileInPlace(
  FileSystem& files, const std::string& path, std::unique_ptr<PathLock>& lock)
{
  ISOSURFACE_RETURN_IF_ERROR(files.Rename(GetPartialEdgeIndexPath(path), path));
  lock.reset();
  const std::size_t slash = path.rfind('/');
  return files.SyncDirectory(slash == std::string::npos ? "."
      : slash == 0                                      ? "/"
                                                        : path.substr(0, slash));
}

} // namespace isosurface
