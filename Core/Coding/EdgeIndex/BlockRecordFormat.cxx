// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/BlockRecordFormat.h"

#include "Coding/Prediction/SignRows.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <algorithm>

namespace isosurface
{
namespace
{

constexpr std::size_t RecordChecksumSize = 4;
constexpr std::int64_t LatticeLimit = std::int64_t(1) << 34;
constexpr std::int64_t LowVertexLimit = std::int64_t(1) << 42;
constexpr std::int64_t ScaleLimit = 1100;

Status MakeCorruptRecord(const char* reason)
{
  return { StatusCode::Corrupt, std::string("The record of an edge-index block ") + reason + "." };
}

// Reads which of a block's islands are kept: some, but not all.
bool ReadKept(ByteReader& reader, std::vector<bool>& areKept)
{
  const auto islands = reader.ReadVarint<std::size_t>();
  const std::size_t size = islands / 8 + (islands % 8 > 0 ? 1 : 0);
  const std::uint8_t* bits = reader.ReadBytes(size);
  if (!bits || reader.HasFailed() || (islands % 8 > 0 && bits[size - 1] >> islands % 8 != 0))
  {
    return false;
  }
  for (std::size_t island = 0; island < islands; ++island)
  {
    areKept.push_back((bits[island / 8] >> island % 8 & 1) != 0);
  }
  const auto kept = std::count(areKept.begin(), areKept.end(), true);
  return kept > 0 && static_cast<std::size_t>(kept) < islands;
}

Status CheckPlace(const EdgeIndexHeader& header, const EdgeIndexBlock& block)
{
  const Index3 dimensions =
    header.Geometry.Coarsen(block.IsPreview ? header.PreviewLevel : 0).GetDimensions();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t cells = block.Vertices.High[axis] - block.Vertices.Low[axis] - 1;
    if (block.Vertices.Low[axis] < 0 || cells < 1 || cells > MaximumCodedCells ||
      block.Vertices.Low[axis] > dimensions[axis] - 1 - cells)
    {
      return MakeCorruptRecord("lies beyond the grid");
    }
    if (block.Lattice[axis] < -LatticeLimit || block.Lattice[axis] > LatticeLimit)
    {
      return MakeCorruptRecord("has impossible lattice coordinates");
    }
  }
  const bool mayBeWithin = !block.IsPreview && header.ClosedSides.Touch(block.Vertices, dimensions);
  if ((block.NumberOfPoints == 0 && !mayBeWithin) ||
    block.NumberOfPoints > 3 * static_cast<std::uint64_t>(block.Vertices.GetNumberOfVertices()))
  {
    return MakeCorruptRecord("has an impossible number of points");
  }
  return Status::Ok();
}

} // namespace

void EdgeIndexBlock::Append(std::vector<std::uint8_t>& bytes) const
{
  AppendVarint(bytes, this->Isovalue);
  for (const std::int64_t low : this->Vertices.Low)
  {
    AppendVarint(bytes, static_cast<std::uint64_t>(low));
  }
  const Index3 size = this->Vertices.GetSize();
  for (const std::int64_t vertices : size)
  {
    bytes.push_back(static_cast<std::uint8_t>(vertices - 1));
  }
  for (const std::int64_t coordinate : this->Lattice)
  {
    AppendSignedVarint(bytes, coordinate);
  }
  AppendVarint(bytes, this->NumberOfPoints);
  bytes.push_back(static_cast<std::uint8_t>(static_cast<int>(this->Coding) +
    (this->HasMissing ? 2 : 0) + (this->IsPreview ? 4 : 0) + (this->LacksIslands ? 8 : 0)));
}

Result<EdgeIndexBlock> EdgeIndexBlock::Parse(const EdgeIndexHeader& header, ByteReader& reader)
{
  EdgeIndexBlock block;
  const auto isovalue = reader.ReadVarint<std::int64_t>();
  bool inRange = static_cast<std::uint64_t>(isovalue) < header.Isovalues.size();
  for (std::int64_t& low : block.Vertices.Low)
  {
    low = reader.ReadVarint<std::int64_t>();
    inRange = inRange && low < LowVertexLimit;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto cells = reader.Read<std::uint8_t>();
    block.Vertices.High[axis] = inRange ? block.Vertices.Low[axis] + cells + 1 : 0;
  }
  for (std::int64_t& coordinate : block.Lattice)
  {
    coordinate = reader.ReadSignedVarint();
  }
  block.NumberOfPoints = static_cast<std::uint64_t>(reader.ReadVarint<std::int64_t>());
  const auto coding = reader.Read<std::uint8_t>();
  const bool crossings = (coding & 1) != 0;
  block.Isovalue = static_cast<std::size_t>(isovalue);
  block.Coding = crossings ? CodedGeometry::Crossings : CodedGeometry::Values;
  block.HasMissing = (coding & 2) != 0;
  block.IsPreview = (coding & 4) != 0;
  block.LacksIslands = (coding & 8) != 0;
  if (reader.HasFailed() || !inRange || coding > (header.LacksIslands ? 15 : 7) ||
    (!crossings && block.HasMissing) || (block.IsPreview && header.PreviewLevel == 0))
  {
    return MakeCorruptRecord("holds impossible numbers");
  }
  const EdgeIndexMode mode = block.IsPreview ? EdgeIndexMode::Bounded : header.Settings.Mode;
  if (mode != EdgeIndexMode::Smallest && crossings != (mode == EdgeIndexMode::Bounded))
  {
    return MakeCorruptRecord("is coded in another mode than the stream");
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckPlace(header, block));
  return block;
}

bool EdgeIndexBlock::operator==(const EdgeIndexBlock& other) const
{
  return this->Isovalue == other.Isovalue && this->Vertices == other.Vertices &&
    this->Lattice == other.Lattice && this->NumberOfPoints == other.NumberOfPoints &&
    this->Coding == other.Coding && this->HasMissing == other.HasMissing &&
    this->IsPreview == other.IsPreview && this->LacksIslands == other.LacksIslands;
}

void EdgeIndexRecord::Append(std::vector<std::uint8_t>& bytes) const
{
  std::vector<std::uint8_t> head;
  this->Block.Append(head);
  if (this->Block.Coding == CodedGeometry::Values)
  {
    AppendSignedVarint(head, this->Scale);
  }
  if (this->Block.LacksIslands)
  {
    AppendVarint(head, this->AreKept.size());
    const std::size_t first = head.size();
    head.resize(first + (this->AreKept.size() + 7) / 8);
    for (std::size_t island = 0; island < this->AreKept.size(); ++island)
    {
      head[first + island / 8] |= static_cast<std::uint8_t>(this->AreKept[island] << island % 8);
    }
  }
  AppendVarint(bytes, head.size() + this->CodeSize + RecordChecksumSize);
  const std::size_t first = bytes.size();
  bytes.insert(bytes.end(), head.begin(), head.end());
  bytes.insert(bytes.end(), this->Code, this->Code + this->CodeSize);
  AppendLittleEndian(
    bytes, static_cast<std::uint32_t>(ComputeChecksum(bytes.data() + first, bytes.size() - first)));
}

std::uint64_t EdgeIndexRecord::ReadSize(const std::uint8_t* bytes, std::size_t size)
{
  ByteReader reader(bytes, size);
  const auto length = static_cast<std::uint64_t>(reader.ReadVarint<std::int64_t>());
  return reader.HasFailed() || length == 0 || length > std::uint64_t(1) << 62
    ? 0
    : length + (size - reader.GetRemaining());
}

Result<EdgeIndexRecord> EdgeIndexRecord::Parse(
  const EdgeIndexHeader& header, const std::uint8_t* bytes, std::size_t size, std::size_t& used)
{
  used = 0;
  ByteReader outer(bytes, size);
  const auto length = outer.ReadVarint<std::size_t>();
  const std::size_t sizeBytes = size - outer.GetRemaining();
  const std::uint8_t* first = outer.ReadBytes(length);
  if (!first || outer.HasFailed())
  {
    return MakeCorruptRecord("is cut off");
  }
  if (length < RecordChecksumSize)
  {
    return MakeCorruptRecord("is too short");
  }
  const std::size_t content = length - RecordChecksumSize;
  if (LoadLittleEndian<std::uint32_t>(first + content) !=
    static_cast<std::uint32_t>(ComputeChecksum(first, content)))
  {
    return MakeCorruptRecord("does not match its checksum");
  }
  ByteReader reader(first, content);
  ISOSURFACE_ASSIGN_OR_RETURN(const EdgeIndexBlock block, EdgeIndexBlock::Parse(header, reader));
  EdgeIndexRecord record;
  record.Block = block;
  const std::int64_t scale =
    block.Coding == CodedGeometry::Crossings ? 0 : reader.ReadSignedVarint();
  if (reader.HasFailed() || scale < -ScaleLimit || scale > ScaleLimit)
  {
    return MakeCorruptRecord("has an impossible scale");
  }
  record.Scale = static_cast<int>(scale);
  if (record.Block.LacksIslands && !ReadKept(reader, record.AreKept))
  {
    return MakeCorruptRecord("does not tell which of its islands are kept");
  }
  record.CodeSize = reader.GetRemaining();
  record.Code = first + content - record.CodeSize;
  used = sizeBytes + length;
  return record;
}

} // namespace isosurface
