// SPDX-License-Identifier: BSD-3-Clause
// Input: flags (1 byte: 1 seals the pages), blocks of the volume (uint32), pages of the file of
// blocks (uint32), the file of a directory. Its entries are read, as many as it says it has.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Ground/Base/Coding.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/BlockDirectory.h"

#include <algorithm>
#include <string>

using namespace isosurface;

namespace
{

const std::string Path = "/data/directory";
constexpr std::size_t PrefixSize = 9;
constexpr std::size_t CacheBytes = 16 * 1024;
constexpr std::size_t ClientAreaOffset = 32;
constexpr std::uint64_t EntryLimit = 2000;

void CheckEntry(const BlockDirectoryEntry& entry, std::size_t segments, std::int64_t blocks,
  std::uint64_t fileSize)
{
  Require(entry.Block >= 0 && entry.Block < blocks, "an entry's block is in the volume");
  Require(entry.Lengths.size() == segments, "an entry has the segments of the volume");
  Require(entry.Offset <= fileSize && entry.FindSegment(segments) <= fileSize - entry.Offset,
    "an entry's record is within the file");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < PrefixSize)
  {
    return 0;
  }
  const bool isSealed = (bytes[0] & 1) != 0;
  const std::int64_t blocks = LoadLittleEndian<std::uint32_t>(bytes + 1);
  const std::uint64_t fileSize =
    LoadLittleEndian<std::uint32_t>(bytes + 5) * BlockRecord::Alignment;
  SealedBytes file = isSealed ? SealPages(bytes + PrefixSize, size - PrefixSize, "BLOCKDIR")
                              : SealedBytes(bytes + PrefixSize, bytes + size);
  // The header promises what the directory says, within what a header can promise.
  std::uint64_t entries = 0;
  std::size_t segments = 1;
  std::uint64_t identity = 0;
  if (file.size() >= ClientAreaOffset + 24)
  {
    entries = LoadLittleEndian<std::uint64_t>(file.data() + ClientAreaOffset);
    segments =
      std::clamp<std::size_t>(LoadLittleEndian<std::uint32_t>(file.data() + ClientAreaOffset + 8),
        1, BlockDirectory::MaximumSegments);
    identity = LoadLittleEndian<std::uint64_t>(file.data() + ClientAreaOffset + 16);
  }
  MemoryDisk disk;
  PutFile(disk, Path, std::move(file));

  // The cache, a page and one entry's lengths.
  const MemoryLimit limit(CacheBytes + std::size_t{ 128 } * 1024);
  const auto directory = BlockDirectory::Open(disk, Path, entries, segments, identity, CacheBytes);
  if (!directory.IsOk())
  {
    Require(directory.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
    return 0;
  }
  QueryStatistics statistics;
  const std::uint64_t step = 1 + (*directory)->GetCount() / EntryLimit;
  for (std::uint64_t ordinal = 0; ordinal <= (*directory)->GetCount(); ordinal += step)
  {
    const auto entry = (*directory)->Read(ordinal, blocks, fileSize, statistics);
    if (entry.IsOk())
    {
      CheckEntry(*entry, segments, blocks, fileSize);
    }
    else
    {
      Require(entry.GetStatus().GetCode() == StatusCode::Corrupt, "a bad entry is Corrupt");
    }
  }
  return 0;
}
