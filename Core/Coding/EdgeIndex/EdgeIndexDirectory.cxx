// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexDirectory.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <cstring>

namespace isosurface
{
namespace
{

constexpr char TrailerMagic[8] = { 'E', 'I', 'X', 'e', 'n', 'd', '.', '\n' };
constexpr std::size_t DirectoryChecksumSize = 8;
/// The minimum size of an entry: a size and the eleven fields of a block, one byte each.
constexpr std::size_t MinimumEntrySize = 12;

std::uint64_t GetHeaderChecksum(const std::vector<std::uint8_t>& headerBytes)
{
  return LoadLittleEndian<std::uint64_t>(
    headerBytes.data() + headerBytes.size() - DirectoryChecksumSize);
}

Status MakeCorruptDirectory(const char* reason)
{
  return { StatusCode::Corrupt, std::string("The directory of blocks ") + reason + "." };
}

} // namespace

void EdgeIndexDirectory::Append(const std::vector<EdgeIndexEntry>& entries,
  const std::vector<std::uint8_t>& headerBytes, std::vector<std::uint8_t>& bytes)
{
  const std::uint64_t seed = GetHeaderChecksum(headerBytes);
  const std::size_t first = bytes.size();
  bytes.push_back(0);
  AppendVarint(bytes, entries.size());
  std::uint64_t offset = headerBytes.size();
  for (const EdgeIndexEntry& entry : entries)
  {
    AppendVarint(bytes, entry.Size);
    entry.Block.Append(bytes);
    offset += entry.Size;
  }
  bytes.resize(bytes.size() + DirectoryChecksumSize);
  const std::size_t size = bytes.size() - first;
  StoreLittleEndian(bytes.data() + first + size - DirectoryChecksumSize,
    ComputeChecksum(bytes.data() + first, size - DirectoryChecksumSize, seed));

  std::uint8_t trailer[TrailerSize];
  StoreLittleEndian(trailer, offset);
  StoreLittleEndian(trailer + 8, static_cast<std::uint64_t>(size));
  StoreLittleEndian(trailer + 16, ComputeChecksum(trailer, 16, seed));
  std::memcpy(trailer + 24, TrailerMagic, sizeof(TrailerMagic));
  bytes.insert(bytes.end(), trailer, trailer + TrailerSize);
}

std::uint64_t EdgeIndexDirectory::ParseTrailer(
  const std::uint8_t* trailer, const std::vector<std::uint8_t>& headerBytes, std::uint64_t fileSize)
{
  const auto offset = LoadLittleEndian<std::uint64_t>(trailer);
  const auto size = LoadLittleEndian<std::uint64_t>(trailer + 8);
  const bool isTrailer = std::memcmp(trailer + 24, TrailerMagic, sizeof(TrailerMagic)) == 0 &&
    LoadLittleEndian<std::uint64_t>(trailer + 16) ==
      ComputeChecksum(trailer, 16, GetHeaderChecksum(headerBytes));
  const bool fits = offset >= headerBytes.size() && offset < fileSize - TrailerSize &&
    size == fileSize - TrailerSize - offset && size > DirectoryChecksumSize;
  return isTrailer && fits ? offset : 0;
}

Result<std::vector<EdgeIndexEntry>> EdgeIndexDirectory::Parse(const EdgeIndexHeader& header,
  const std::vector<std::uint8_t>& headerBytes, const std::vector<std::uint8_t>& bytes,
  std::uint64_t offset)
{
  if (bytes.size() <= DirectoryChecksumSize ||
    LoadLittleEndian<std::uint64_t>(bytes.data() + bytes.size() - DirectoryChecksumSize) !=
      ComputeChecksum(
        bytes.data(), bytes.size() - DirectoryChecksumSize, GetHeaderChecksum(headerBytes)))
  {
    return MakeCorruptDirectory("does not match its checksum");
  }
  ByteReader reader(bytes.data(), bytes.size() - DirectoryChecksumSize);
  const auto mark = reader.Read<std::uint8_t>();
  const auto count = reader.ReadVarint();
  if (mark != 0 || reader.HasFailed() || count > reader.GetRemaining() / MinimumEntrySize)
  {
    return MakeCorruptDirectory("has a size that does not fit");
  }
  std::vector<EdgeIndexEntry> entries;
  entries.reserve(static_cast<std::size_t>(count));
  std::uint64_t next = headerBytes.size();
  for (std::uint64_t n = 0; n < count; ++n)
  {
    EdgeIndexEntry entry;
    entry.Offset = next;
    entry.Size = reader.ReadVarint();
    ISOSURFACE_ASSIGN_OR_RETURN(entry.Block, EdgeIndexBlock::Parse(header, reader));
    if (entry.Size == 0 || entry.Size > offset - next)
    {
      return MakeCorruptDirectory("names records that are not there");
    }
    next += entry.Size;
    entries.push_back(entry);
  }
  if (reader.GetRemaining() != 0 || next != offset)
  {
    return MakeCorruptDirectory("does not name all records");
  }
  return entries;
}

} // namespace isosurface
