// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockRecordFormat.h"

#include "Base/ByteOrder.h"
#include "Base/Checksum.h"
#include "EdgeIndex/SignRows.h"

#include <cstdlib>

namespace isosurface
{
namespace
{

constexpr std::size_t ChecksumSize = 4;
constexpr std::int64_t LatticeLimit = std::int64_t(1) << 34;

void AppendNumber(std::vector<std::uint8_t>& bytes, std::uint64_t number)
{
  while (number > 127)
  {
    bytes.push_back(static_cast<std::uint8_t>(number | 128));
    number >>= 7;
  }
  bytes.push_back(static_cast<std::uint8_t>(number));
}

void AppendSigned(std::vector<std::uint8_t>& bytes, std::int64_t number)
{
  AppendNumber(bytes,
    (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63));
}

// Reads what the functions above wrote; after an error everything is 0.
class NumberReader
{
public:
  NumberReader(const std::uint8_t* bytes, std::size_t size)
    : Next(bytes)
    , End(bytes + size)
  {
  }
  std::uint64_t ReadNumber()
  {
    std::uint64_t number = 0;
    for (int shift = 0; shift < 63; shift += 7)
    {
      const std::uint8_t byte = this->ReadByte();
      number |= static_cast<std::uint64_t>(byte & 127) << shift;
      if (byte < 128)
      {
        return number;
      }
    }
    this->Failed = true;
    return 0;
  }
  std::int64_t ReadSigned()
  {
    const std::uint64_t number = this->ReadNumber();
    return static_cast<std::int64_t>((number >> 1) ^ (0 - (number & 1)));
  }
  std::uint8_t ReadByte()
  {
    if (this->Next == this->End)
    {
      this->Failed = true;
      return 0;
    }
    return *this->Next++;
  }
  const std::uint8_t* GetNext() const { return this->Next; }
  std::size_t GetLeft() const { return static_cast<std::size_t>(this->End - this->Next); }
  bool HasFailed() const { return this->Failed; }

private:
  const std::uint8_t* Next;
  const std::uint8_t* End;
  bool Failed = false;
};

Status MakeCorrupt(const char* reason)
{
  return { StatusCode::Corrupt, std::string("The record of an edge-index block ") + reason + "." };
}

Status CheckPlace(const EdgeIndexHeader& header, const EdgeIndexRecord& record)
{
  const Index3 dimensions = header.Geometry.GetDimensions();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t cells = record.Vertices.High[axis] - record.Vertices.Low[axis] - 1;
    if (record.Vertices.Low[axis] < 0 || cells < 1 || cells > MaximumCodedCells ||
      record.Vertices.Low[axis] > dimensions[axis] - 1 - cells)
    {
      return MakeCorrupt("lies beyond the grid");
    }
    if (record.Lattice[axis] < -LatticeLimit || record.Lattice[axis] > LatticeLimit)
    {
      return MakeCorrupt("has lattice coordinates that cannot be");
    }
  }
  return Status::Ok();
}

} // namespace

void EdgeIndexRecord::Append(std::vector<std::uint8_t>& bytes) const
{
  std::vector<std::uint8_t> head;
  AppendNumber(head, this->Isovalue);
  for (const std::int64_t low : this->Vertices.Low)
  {
    AppendNumber(head, static_cast<std::uint64_t>(low));
  }
  const Index3 size = this->Vertices.GetSize();
  for (const std::int64_t vertices : size)
  {
    head.push_back(static_cast<std::uint8_t>(vertices - 1));
  }
  for (const std::int64_t coordinate : this->Lattice)
  {
    AppendSigned(head, coordinate);
  }
  head.push_back(
    static_cast<std::uint8_t>(static_cast<int>(this->Coding) + (this->HasMissing ? 2 : 0)));
  if (this->Coding == BlockCoding::Values)
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

Result<EdgeIndexRecord> EdgeIndexRecord::Parse(const EdgeIndexHeader& header,
  const std::uint8_t* bytes, std::size_t size, std::size_t& used)
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
  EdgeIndexRecord record;
  const std::uint64_t isovalue = reader.ReadNumber();
  constexpr std::uint64_t most = std::uint64_t(1) << 42;
  bool inRange = isovalue < header.Isovalues.size();
  for (std::int64_t& low : record.Vertices.Low)
  {
    const std::uint64_t number = reader.ReadNumber();
    inRange = inRange && number < most;
    low = static_cast<std::int64_t>(number);
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::uint8_t cells = reader.ReadByte();
    record.Vertices.High[axis] = inRange ? record.Vertices.Low[axis] + cells + 1 : 0;
  }
  for (std::int64_t& coordinate : record.Lattice)
  {
    coordinate = reader.ReadSigned();
  }
  const std::uint8_t coding = reader.ReadByte();
  const bool crossings = (coding & 1) != 0;
  record.Coding = crossings ? BlockCoding::Crossings : BlockCoding::Values;
  record.HasMissing = (coding & 2) != 0;
  const std::int64_t scale = crossings ? 0 : reader.ReadSigned();
  if (reader.HasFailed() || !inRange || coding > 3 || (!crossings && record.HasMissing) ||
    scale < -1100 || scale > 1100)
  {
    return MakeCorrupt("holds numbers that cannot be");
  }
  const EdgeIndexMode mode = header.Settings.Mode;
  if (mode != EdgeIndexMode::Smallest && crossings != (mode == EdgeIndexMode::Bounded))
  {
    return MakeCorrupt("is coded in another mode than the stream");
  }
  record.Isovalue = static_cast<std::size_t>(isovalue);
  record.Scale = static_cast<int>(scale);
  record.Code = reader.GetNext();
  record.CodeSize = reader.GetLeft();
  ISOSURFACE_RETURN_IF_ERROR(CheckPlace(header, record));
  used = static_cast<std::size_t>(first - bytes) + static_cast<std::size_t>(length);
  return record;
}

} // namespace isosurface
