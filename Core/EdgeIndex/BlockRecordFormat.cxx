// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockRecordFormat.h"

#include "Base/Checksum.h"
#include "Base/Coding.h"
#include "EdgeIndex/CodedNumbers.h"
#include "EdgeIndex/SignRows.h"

#include <cstdlib>

namespace isosurface
{
namespace
{

constexpr std::size_t ChecksumSize = 4;
constexpr std::int64_t LatticeLimit = std::int64_t(1) << 34;

Status MakeCorrupt(const char* reason)
{
  return { StatusCode::Corrupt, std::string("The record of an edge-index block ") + reason + "." };
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
      return MakeCorrupt("lies beyond the grid");
    }
    if (block.Lattice[axis] < -LatticeLimit || block.Lattice[axis] > LatticeLimit)
    {
      return MakeCorrupt("has lattice coordinates that cannot be");
    }
  }
  if (block.NumberOfPoints == 0 ||
    block.NumberOfPoints > 3 * static_cast<std::uint64_t>(block.Vertices.GetNumberOfVertices()))
  {
    return MakeCorrupt("has a number of points that cannot be");
  }
  return Status::Ok();
}

} // namespace

void EdgeIndexBlock::Append(std::vector<std::uint8_t>& bytes) const
{
  AppendNumber(bytes, this->Isovalue);
  for (const std::int64_t low : this->Vertices.Low)
  {
    AppendNumber(bytes, static_cast<std::uint64_t>(low));
  }
  const Index3 size = this->Vertices.GetSize();
  for (const std::int64_t vertices : size)
  {
    bytes.push_back(static_cast<std::uint8_t>(vertices - 1));
  }
  for (const std::int64_t coordinate : this->Lattice)
  {
    AppendSigned(bytes, coordinate);
  }
  AppendNumber(bytes, this->NumberOfPoints);
  bytes.push_back(static_cast<std::uint8_t>(
    static_cast<int>(this->Coding) + (this->HasMissing ? 2 : 0) + (this->IsPreview ? 4 : 0)));
}

Result<EdgeIndexBlock> EdgeIndexBlock::Parse(const EdgeIndexHeader& header, NumberReader& reader)
{
  EdgeIndexBlock block;
  const std::uint64_t isovalue = reader.ReadNumber();
  constexpr std::uint64_t most = std::uint64_t(1) << 42;
  bool inRange = isovalue < header.Isovalues.size();
  for (std::int64_t& low : block.Vertices.Low)
  {
    const std::uint64_t number = reader.ReadNumber();
    inRange = inRange && number < most;
    low = inRange ? static_cast<std::int64_t>(number) : 0;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    block.Vertices.High[axis] = block.Vertices.Low[axis] + reader.ReadByte() + 1;
  }
  for (std::int64_t& coordinate : block.Lattice)
  {
    coordinate = reader.ReadSigned();
  }
  block.NumberOfPoints = reader.ReadNumber();
  const std::uint8_t coding = reader.ReadByte();
  const bool crossings = (coding & 1) != 0;
  block.Isovalue = static_cast<std::size_t>(isovalue);
  block.Coding = crossings ? BlockCoding::Crossings : BlockCoding::Values;
  block.HasMissing = (coding & 2) != 0;
  block.IsPreview = (coding & 4) != 0;
  if (reader.HasFailed() || !inRange || coding > 7 || (!crossings && block.HasMissing) ||
    (block.IsPreview && header.PreviewLevel == 0))
  {
    return MakeCorrupt("holds numbers that cannot be");
  }
  const EdgeIndexMode mode = block.IsPreview ? EdgeIndexMode::Bounded : header.Settings.Mode;
  if (mode != EdgeIndexMode::Smallest && crossings != (mode == EdgeIndexMode::Bounded))
  {
    return MakeCorrupt("is coded in another mode than the stream");
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckPlace(header, block));
  return block;
}

bool EdgeIndexBlock::operator==(const EdgeIndexBlock& other) const
{
  return this->Isovalue == other.Isovalue && this->Vertices == other.Vertices &&
    this->Lattice == other.Lattice && this->NumberOfPoints == other.NumberOfPoints &&
    this->Coding == other.Coding && this->HasMissing == other.HasMissing &&
    this->IsPreview == other.IsPreview;
}

void EdgeIndexRecord::Append(std::vector<std::uint8_t>& bytes) const
{
  std::vector<std::uint8_t> head;
  this->Block.Append(head);
  if (this->Block.Coding == BlockCoding::Values)
  {
    AppendSigned(head, this->Scale);
  }
  AppendNumber(bytes, head.size() + this->CodeSize + ChecksumSize);
  const std::size_t first = bytes.size();
  bytes.insert(bytes.end(), head.begin(), head.end());
  bytes.insert(bytes.end(), this->Code, this->Code + this->CodeSize);
  std::uint8_t checksum[ChecksumSize];
  StoreLittleEndian(checksum,
    static_cast<std::uint32_t>(ComputeChecksum(bytes.data() + first, bytes.size() - first)));
  bytes.insert(bytes.end(), checksum, checksum + ChecksumSize);
}

std::uint64_t EdgeIndexRecord::ReadSize(const std::uint8_t* bytes, std::size_t size)
{
  NumberReader reader(bytes, size);
  const std::uint64_t length = reader.ReadNumber();
  return reader.HasFailed() || length == 0 || length > std::uint64_t(1) << 62
    ? 0
    : length + static_cast<std::uint64_t>(reader.GetNext() - bytes);
}

Result<EdgeIndexRecord> EdgeIndexRecord::Parse(
  const EdgeIndexHeader& header, const std::uint8_t* bytes, std::size_t size, std::size_t& used)
{
  used = 0;
  NumberReader outer(bytes, size);
  const std::uint64_t length = outer.ReadNumber();
  if (outer.HasFailed() || length > outer.GetLeft())
  {
    return MakeCorrupt("is cut off");
  }
  if (length < ChecksumSize)
  {
    return MakeCorrupt("is too short");
  }
  const std::uint8_t* first = outer.GetNext();
  const std::size_t content = static_cast<std::size_t>(length) - ChecksumSize;
  if (LoadLittleEndian<std::uint32_t>(first + content) !=
    static_cast<std::uint32_t>(ComputeChecksum(first, content)))
  {
    return MakeCorrupt("does not match its checksum");
  }
  NumberReader reader(first, content);
  const Result<EdgeIndexBlock> block = EdgeIndexBlock::Parse(header, reader);
  if (!block.IsOk())
  {
    return block.GetStatus();
  }
  EdgeIndexRecord record;
  record.Block = *block;
  const std::int64_t scale = block->Coding == BlockCoding::Crossings ? 0 : reader.ReadSigned();
  if (reader.HasFailed() || scale < -1100 || scale > 1100)
  {
    return MakeCorrupt("has a scale that cannot be");
  }
  record.Scale = static_cast<int>(scale);
  record.Code = reader.GetNext();
  record.CodeSize = reader.GetLeft();
  used = static_cast<std::size_t>(first - bytes) + static_cast<std::size_t>(length);
  return record;
}

} // namespace isosurface
