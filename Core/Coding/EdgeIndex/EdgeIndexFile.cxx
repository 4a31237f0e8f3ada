// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexFile.h"

#include "Coding/EdgeIndex/EdgeIndexDecoder.h"
#include "Coding/EdgeIndex/IsovalueJoin.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/WithinMemory.h"

#include <algorithm>
#include <new>
#include <numeric>
#include <utility>

namespace isosurface
{
namespace
{

/// The maximum of bytes that the size of a record takes.
constexpr std::size_t SizePrefix = 10;

// Blocks of one isovalue; each is read when an extraction acquires it.
class FileBlockSource : public CodedBlockSource
{
public:
  FileBlockSource(
    const EdgeIndexFile& file, const EdgeIndexHeader& header, std::vector<std::size_t> entries)
    : CodedBlockSource(header)
    , File(file)
    , Blocks(std::move(entries))
  {
  }

  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Get(block).Lattice;
  }
  VertexBox GetVertices(std::size_t block) const override { return this->Get(block).Vertices; }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    std::vector<std::uint8_t> bytes;
    ISOSURFACE_ASSIGN_OR_RETURN(
      const EdgeIndexRecord record, this->File.ReadRecord(this->Blocks[block], bytes));
    return this->Decoder.Decode(record);
  }

private:
  const EdgeIndexBlock& Get(std::size_t block) const
  {
    return this->File.GetEntries()[this->Blocks[block]].Block;
  }

  const EdgeIndexFile& File;
  std::vector<std::size_t> Blocks;
};

// Whether a block has cells in a box, or a flat box cuts it. step: the distance of the block's vertices
// in the grid.
bool Overlaps(const VertexBox& block, std::int64_t step, const VertexBox& box)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t low = std::max(block.Low[axis] * step, box.Low[axis]);
    const std::int64_t last = std::min((block.High[axis] - 1) * step, box.High[axis] - 1);
    const bool isFlat = box.High[axis] - box.Low[axis] == 1;
    if (last < low || (last == low && !isFlat))
    {
      return false;
    }
  }
  return true;
}

// Keeps those of the selected entries that belong to a piece; pieces have about equal numbers of points.
void KeepPiece(const std::vector<EdgeIndexEntry>& entries, int piece, int pieces,
  std::vector<std::size_t>& selected)
{
  // A block within a closed surface has caps alone.
  const auto count = [&entries](std::size_t entry)
  { return static_cast<double>(std::max<std::uint64_t>(1, entries[entry].Block.NumberOfPoints)); };
  double points = 0;
  for (const std::size_t entry : selected)
  {
    points += count(entry);
  }
  double before = 0;
  std::vector<std::size_t> kept;
  for (const std::size_t entry : selected)
  {
    const double own = count(entry);
    const int place = std::min(
      pieces - 1, static_cast<int>((before + own / 2) / points * static_cast<double>(pieces)));
    before += own;
    if (place == piece)
    {
      kept.push_back(entry);
    }
  }
  selected = std::move(kept);
}

} // namespace

EdgeIndexFile::EdgeIndexFile(std::unique_ptr<RandomAccessFile> file, EdgeIndexHeader header,
  std::vector<std::uint8_t> headerBytes)
  : File(std::move(file))
  , Header(std::move(header))
  , Preview(this->Header.MakePreview())
  , HeaderBytes(std::move(headerBytes))
{
}

Status EdgeIndexFile::NameFile(const Status& status) const
{
  const std::string& message = status.GetMessage();
  return status.IsOk() || message.compare(0, this->GetPath().size(), this->GetPath()) == 0
    ? status
    : Status(status.GetCode(), this->GetPath() + ": " + message);
}

Result<std::unique_ptr<EdgeIndexFile>> EdgeIndexFile::Open(
  FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(std::unique_ptr<RandomAccessFile> opened, files.OpenForReading(path));
  const auto nameFile = [&path](const Status& status)
  { return Status(status.GetCode(), path + ": " + status.GetMessage()); };
  try
  {
    std::vector<std::uint8_t> bytes(EdgeIndexHeader::MinimumSize);
    const std::uint64_t there = std::min<std::uint64_t>(bytes.size(), opened->GetSize());
    ISOSURFACE_RETURN_IF_ERROR(opened->Read(0, static_cast<std::size_t>(there), bytes.data()));
    if (there < bytes.size() && EdgeIndexHeader::HasMagic(bytes.data()))
    {
      return Status(StatusCode::Corrupt, path + ": The edge-index header is cut off.");
    }
    const Result<std::size_t> size = EdgeIndexHeader::ParseSize(bytes.data());
    if (!size.IsOk())
    {
      return nameFile(size.GetStatus());
    }
    if (*size > opened->GetSize())
    {
      return Status(StatusCode::Corrupt, path + ": The edge-index header is cut off.");
    }
    bytes.resize(*size);
    ISOSURFACE_RETURN_IF_ERROR(opened->Read(0, bytes.size(), bytes.data()));
    std::size_t used = 0;
    Result<EdgeIndexHeader> header = EdgeIndexHeader::Parse(bytes.data(), bytes.size(), used);
    if (!header.IsOk())
    {
      return nameFile(header.GetStatus());
    }
    std::unique_ptr<EdgeIndexFile> file(
      new EdgeIndexFile(std::move(opened), std::move(*header), std::move(bytes)));
    ISOSURFACE_RETURN_IF_ERROR(file->ReadDirectory());
    return file;
  }
  catch (const std::bad_alloc&)
  {
    return Status(
      StatusCode::OutOfMemory, path + ": there is not enough memory for its directory.");
  }
}

std::uint64_t EdgeIndexFile::GetFingerprint() const
{
  Fingerprint fingerprint;
  fingerprint.AddNumber(ComputeChecksum(this->HeaderBytes.data(), this->HeaderBytes.size()));
  for (const EdgeIndexEntry& entry : this->Entries)
  {
    fingerprint.AddNumber(entry.Offset);
    fingerprint.AddNumber(entry.Size);
  }
  return fingerprint.Get();
}

Status EdgeIndexFile::ReadDirectory()
{
  const std::uint64_t size = this->GetSize();
  if (size < this->HeaderBytes.size() + EdgeIndexDirectory::TrailerSize)
  {
    return this->ScanRecords();
  }
  std::uint8_t trailer[EdgeIndexDirectory::TrailerSize];
  ISOSURFACE_RETURN_IF_ERROR(this->File->Read(size - sizeof(trailer), sizeof(trailer), trailer));
  const std::uint64_t offset = EdgeIndexDirectory::ParseTrailer(trailer, this->HeaderBytes, size);
  if (offset == 0)
  {
    return this->ScanRecords();
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size - sizeof(trailer) - offset));
  ISOSURFACE_RETURN_IF_ERROR(this->File->Read(offset, bytes.size(), bytes.data()));
  Result<std::vector<EdgeIndexEntry>> entries =
    EdgeIndexDirectory::Parse(this->Header, this->HeaderBytes, bytes, offset);
  if (!entries.IsOk())
  {
    return this->ScanRecords();
  }
  this->Entries = std::move(*entries);
  return Status::Ok();
}

Status EdgeIndexFile::ScanRecords()
{
  const std::uint64_t size = this->GetSize();
  std::uint64_t offset = this->HeaderBytes.size();
  std::vector<std::uint8_t> bytes;
  bool atEnd = false;
  while (offset < size && !atEnd)
  {
    bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(SizePrefix, size - offset)));
    ISOSURFACE_RETURN_IF_ERROR(this->File->Read(offset, bytes.size(), bytes.data()));
    atEnd = bytes[0] == 0;
    const std::uint64_t recordSize = EdgeIndexRecord::ReadSize(bytes.data(), bytes.size());
    if (recordSize == 0 || recordSize > size - offset)
    {
      break;
    }
    bytes.resize(static_cast<std::size_t>(recordSize));
    ISOSURFACE_RETURN_IF_ERROR(this->File->Read(offset, bytes.size(), bytes.data()));
    std::size_t used = 0;
    const Result<EdgeIndexRecord> record =
      EdgeIndexRecord::Parse(this->Header, bytes.data(), bytes.size(), used);
    if (!record.IsOk())
    {
      break;
    }
    this->Entries.push_back({ offset, recordSize, record->Block });
    offset += recordSize;
  }
  if (atEnd)
  {
    this->Missing = this->GetPath() + ": the directory is damaged or cut off; all " +
      std::to_string(this->Entries.size()) + " blocks are complete.";
    return Status::Ok();
  }
  this->Missing = this->GetPath() +
    ": the file was cut off, is damaged, or is still being written: " +
    std::to_string(this->Entries.size()) + " blocks are complete";
  if (this->Header.NumberOfBlocks > 0)
  {
    this->Missing += ", of at most " + std::to_string(this->Header.NumberOfBlocks) +
      " an isovalue (" + std::to_string(this->Header.Isovalues.size()) + ")";
  }
  this->Missing += "; " + std::to_string(size - offset) + " bytes after them are not used.";
  return Status::Ok();
}

Result<std::vector<std::size_t>> EdgeIndexFile::Select(const EdgeIndexSelection& selection) const
{
  if (selection.NumberOfPieces < 1 || selection.Piece < 0 ||
    selection.Piece >= selection.NumberOfPieces)
  {
    return Status(StatusCode::InvalidArgument, "There is no such piece of an isosurface.");
  }
  if (selection.Preview && this->Header.PreviewLevel == 0)
  {
    return Status(StatusCode::InvalidArgument, this->GetPath() + ": the file has no preview.");
  }
  std::vector<bool> wanted(this->Header.Isovalues.size(), selection.Isovalues.empty());
  for (const std::size_t isovalue : selection.Isovalues)
  {
    if (isovalue >= wanted.size())
    {
      return Status(
        StatusCode::InvalidArgument, this->GetPath() + ": the file has no such isovalue.");
    }
    wanted[isovalue] = true;
  }
  const std::int64_t step = std::int64_t{ 1 }
    << (selection.Preview ? this->Header.PreviewLevel : 0);
  std::vector<std::size_t> selected;
  for (std::size_t n = 0; n < this->Entries.size(); ++n)
  {
    const EdgeIndexBlock& block = this->Entries[n].Block;
    if (block.IsPreview == selection.Preview && wanted[block.Isovalue] &&
      (!selection.Box || Overlaps(block.Vertices, step, *selection.Box)))
    {
      selected.push_back(n);
    }
  }
  if (selection.NumberOfPieces > 1)
  {
    KeepPiece(this->Entries, selection.Piece, selection.NumberOfPieces, selected);
  }
  return selected;
}

Result<EdgeIndexRecord> EdgeIndexFile::ReadRecord(
  std::size_t entry, std::vector<std::uint8_t>& bytes) const
{
  const EdgeIndexEntry& place = this->Entries[entry];
  bytes.resize(static_cast<std::size_t>(place.Size));
  ISOSURFACE_RETURN_IF_ERROR(this->File->Read(place.Offset, bytes.size(), bytes.data()));
  std::size_t used = 0;
  Result<EdgeIndexRecord> record =
    EdgeIndexRecord::Parse(this->Header, bytes.data(), bytes.size(), used);
  if (!record.IsOk())
  {
    return this->NameFile(record.GetStatus());
  }
  if (used != bytes.size() || !(record->Block == place.Block))
  {
    return Status(StatusCode::Corrupt,
      this->GetPath() + ": the directory does not match the record of a block.");
  }
  return record;
}

Result<Surface> EdgeIndexFile::Read(const EdgeIndexSelection& selection,
  const ContourRequest& request, int threads, const Progress& progress) const
{
  const auto read = [&]() -> Result<Surface>
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const std::vector<std::size_t> selected, this->Select(selection));
    const EdgeIndexHeader& header = selection.Preview ? this->Preview : this->Header;
    std::vector<std::vector<std::size_t>> blocks(header.Isovalues.size());
    for (const std::size_t entry : selected)
    {
      blocks[this->Entries[entry].Block.Isovalue].push_back(entry);
    }
    std::vector<std::size_t> isovalues = selection.Isovalues;
    if (isovalues.empty())
    {
      isovalues.resize(blocks.size());
      std::iota(isovalues.begin(), isovalues.end(), std::size_t{ 0 });
    }
    std::vector<IsovalueSource> sources;
    sources.reserve(isovalues.size());
    for (const std::size_t isovalue : isovalues)
    {
      sources.push_back(
        { isovalue, std::make_unique<FileBlockSource>(*this, header, blocks[isovalue]) });
    }
    return JoinIsovalues(header, sources, request, threads, progress);
  };
  auto surface =
    RunWithinMemory(this->GetPath(), ": there is not enough memory for the isosurface.", read);
  return surface.IsOk() ? std::move(surface) : this->NameFile(surface.GetStatus());
}

Status EdgeIndexFile::Verify(int threads, const Progress& progress) const
{
  FirstFailure failure;
  EdgeIndexBlockDecoder fine(this->Header);
  EdgeIndexBlockDecoder coarse(this->Preview);
  const auto verify = [&](std::size_t entry) -> Status
  {
    std::vector<std::uint8_t> bytes;
    ISOSURFACE_ASSIGN_OR_RETURN(const EdgeIndexRecord record, this->ReadRecord(entry, bytes));
    return this->NameFile((record.Block.IsPreview ? coarse : fine).Decode(record).GetStatus());
  };
  const auto verifyNext = [&](std::size_t entry, int)
  { failure.Run([&] { return verify(entry); }); };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto finished,
    RunWithinMemory(this->GetPath(), ": there is not enough memory to verify it.",
      [&]() -> Result<bool>
      { return ParallelFor(this->Entries.size(), threads, verifyNext, progress); }));
  ISOSURFACE_RETURN_IF_ERROR(failure.Get());
  if (!finished)
  {
    return { StatusCode::Aborted, this->GetPath() + ": the verification was aborted." };
  }
  return this->IsComplete() ? Status::Ok() : Status(StatusCode::Corrupt, this->Missing);
}

} // namespace isosurface
