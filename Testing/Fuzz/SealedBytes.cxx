// SPDX-License-Identifier: BSD-3-Clause
#include "SealedBytes.h"

#include "FuzzTarget.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Storage/Store/JsonDocument.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace isosurface
{

SealedBytes SealPages(const std::uint8_t* bytes, std::size_t size, const char* kind)
{
  constexpr std::size_t headerSize = 32;
  std::size_t pageSize = 4096;
  if (size >= headerSize)
  {
    const auto stated = LoadLittleEndian<std::uint32_t>(bytes + 12);
    pageSize = stated == 8192 || stated == 16384 ? stated : pageSize;
  }
  SealedBytes pages(bytes, bytes + size);
  pages.resize(std::max<std::size_t>(1, size / pageSize) * pageSize);
  std::memcpy(pages.data(), "ISOPAGED", 8);
  StoreLittleEndian(pages.data() + 8, std::uint32_t{ 1 });
  StoreLittleEndian(pages.data() + 12, static_cast<std::uint32_t>(pageSize));
  StoreLittleEndian(pages.data() + 16, static_cast<std::uint64_t>(pages.size() / pageSize));
  std::memcpy(pages.data() + 24, kind, 8);
  for (std::size_t page = 0; page < pages.size() / pageSize; ++page)
  {
    std::uint8_t* begin = pages.data() + page * pageSize;
    StoreLittleEndian(begin + pageSize - 8, ComputeChecksum(begin, pageSize - 8, page));
  }
  return pages;
}

void SealSegmentBytes(std::uint8_t* segment, std::uint32_t stored, std::int64_t block,
  std::uint32_t array, std::uint32_t level)
{
  std::uint8_t place[16];
  StoreLittleEndian(place, static_cast<std::uint64_t>(block));
  StoreLittleEndian(place + 8, array);
  StoreLittleEndian(place + 12, level);
  StoreLittleEndian(segment,
    ComputeChecksum(segment + 8, std::size_t{ 8 } + stored, ComputeChecksum(place, sizeof(place))));
}

std::string SealJson(std::string text)
{
  const std::string name = "\"checksum\"";
  const std::size_t covered = text.rfind(name);
  const std::size_t quote =
    covered == std::string::npos ? covered : text.find('"', covered + name.size());
  if (quote != std::string::npos && text.size() - quote > 16)
  {
    text.replace(quote + 1, 16, FormatChecksum(ComputeChecksum(text.data(), covered)));
  }
  return text;
}

namespace
{

// Seals the record at `at`; returns where the next one is, or `at` if there is none.
std::size_t SealRecord(SealedBytes& file, std::size_t at)
{
  std::uint64_t length = 0;
  std::size_t first = at;
  for (int shift = 0; first < file.size() && shift < 63; shift += 7)
  {
    const std::uint8_t byte = file[first++];
    length |= static_cast<std::uint64_t>(byte & 127) << shift;
    if (byte < 128)
    {
      break;
    }
  }
  if (length < 4 || length > file.size() - first)
  {
    return at;
  }
  const std::size_t content = static_cast<std::size_t>(length) - 4;
  StoreLittleEndian(file.data() + first + content,
    static_cast<std::uint32_t>(ComputeChecksum(file.data() + first, content)));
  return first + static_cast<std::size_t>(length);
}

} // namespace

SealedBytes SealEdgeIndexFile(const std::uint8_t* bytes, std::size_t size)
{
  SealedBytes file(bytes, bytes + size);
  constexpr std::size_t minimumHeader = 264;
  constexpr std::size_t trailerSize = 32;
  if (size < minimumHeader)
  {
    return file;
  }
  std::memcpy(file.data(), "EIXcode\n\1\0\0\0", 12);
  const std::size_t header = LoadLittleEndian<std::uint32_t>(file.data() + 12);
  if (header < minimumHeader || header > size)
  {
    return file;
  }
  const std::uint64_t seed = ComputeChecksum(file.data(), header - 8);
  StoreLittleEndian(file.data() + header - 8, seed);
  std::size_t at = header;
  for (std::size_t next = SealRecord(file, at); next != at; next = SealRecord(file, at))
  {
    at = next;
  }
  if (at < size && file[at] == 0 && size - at > trailerSize + 10)
  {
    std::uint8_t* directory = file.data() + at;
    const std::size_t directorySize = size - at - trailerSize;
    StoreLittleEndian(
      directory + directorySize - 8, ComputeChecksum(directory, directorySize - 8, seed));
    std::uint8_t* trailer = directory + directorySize;
    StoreLittleEndian(trailer, static_cast<std::uint64_t>(at));
    StoreLittleEndian(trailer + 8, static_cast<std::uint64_t>(directorySize));
    StoreLittleEndian(trailer + 16, ComputeChecksum(trailer, 16, seed));
    std::memcpy(trailer + 24, "EIXend.\n", 8);
  }
  return file;
}

void PutFile(MemoryDisk& disk, const std::string& path, SealedBytes bytes)
{
  Require(disk.MakeDirectories(path.substr(0, path.rfind('/'))).IsOk() &&
      disk.CreateForWriting(path).IsOk(),
    "a disk in memory takes a file");
  disk.GetFile(path) = std::move(bytes);
}

} // namespace isosurface
