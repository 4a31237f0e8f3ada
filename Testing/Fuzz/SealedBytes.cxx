// SPDX-License-Identifier: BSD-3-Clause
#include "SealedBytes.h"

#include "FuzzTarget.h"

#include "Base/ByteOrder.h"
#include "Base/Checksum.h"
#include "Store/JsonDocument.h"

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

void PutFile(MemoryDisk& disk, const std::string& path, SealedBytes bytes)
{
  Require(disk.MakeDirectories(path.substr(0, path.rfind('/'))).IsOk() &&
      disk.CreateForWriting(path).IsOk(),
    "a disk in memory takes a file");
  disk.GetFile(path) = std::move(bytes);
}

} // namespace isosurface
