// SPDX-License-Identifier: BSD-3-Clause Input: flags (1 byte), dimensions (3 bytes), value types (2
// bytes), pages of the first array's tree (1 byte), an isovalue (float64); then the files:
// directory, tree, blocks. The first bytes give the header, hence the length of the directory.
// Flags: 1 seals pages and segments, 2 has blocks of 32 cells instead of 16, 4 adds a second array,
// 8 gives the first array 2 to 4 components by the second value type, 16 has two levels in the
// records instead of all. The target finds the active blocks of the isovalue in the first and in
// the last variable, which share the tree, then decodes the first blocks at all levels.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Ground/Base/Coding.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/BlockStore.h"

#include <algorithm>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

const std::string Folder = "/data/store";
constexpr std::size_t PrefixSize = 15;
constexpr std::size_t PageSize = 4096;
constexpr std::uint64_t BlockLimit = 4;
/// Of the store, as the header states it.
constexpr std::uint64_t Checksum = 5;

BlockedVolumeHeader MakeHeader(const std::uint8_t* bytes)
{
  BlockedVolumeHeader header;
  header.BlockSize = (bytes[0] & 2) != 0 ? 32 : 16;
  header.NumberOfLevels = (bytes[0] & 16) != 0 ? 2 : 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    header.Grid.Extent[2 * axis] = 0;
    header.Grid.Extent[2 * axis + 1] = bytes[1 + axis] % 36;
  }
  const int components = (bytes[0] & 8) != 0 ? 2 + bytes[5] % 3 : 1;
  header.Arrays.push_back({ "a", static_cast<ValueType>(bytes[4] % 10), components });
  if ((bytes[0] & 4) != 0)
  {
    header.Arrays.push_back({ "b", static_cast<ValueType>(bytes[5] % 10) });
  }
  return header;
}

/// Takes up to `size` bytes off the input.
SealedBytes Take(const std::uint8_t*& bytes, const std::uint8_t* end, std::size_t size)
{
  const std::size_t taken = std::min(size, static_cast<std::size_t>(end - bytes));
  SealedBytes part(bytes, bytes + taken);
  bytes += taken;
  return part;
}

/// The directory as one that fits the volume's numbers of blocks and segments.
SealedBytes SealDirectory(SealedBytes file, std::uint64_t blocks, std::uint32_t segments)
{
  file.resize(std::max(file.size(), PageSize));
  StoreLittleEndian(file.data() + 12, static_cast<std::uint32_t>(PageSize));
  StoreLittleEndian(file.data() + 32, blocks);
  StoreLittleEndian(file.data() + 40, segments);
  StoreLittleEndian(file.data() + 48, Checksum);
  return SealPages(file.data(), file.size(), "BLOCKDIR");
}

/// The tree as one of as many intervals as there are blocks.
SealedBytes SealTree(SealedBytes file, const StoreDescription& description, std::size_t variable)
{
  const auto blocks = static_cast<std::uint32_t>(description.Blocks);
  file.resize(std::max(file.size(), PageSize));
  StoreLittleEndian(file.data() + 12, static_cast<std::uint32_t>(PageSize));
  StoreLittleEndian(file.data() + 40, std::uint64_t{ blocks });
  StoreLittleEndian(file.data() + 70, blocks); // of the root
  StoreLittleEndian(file.data() + 80, BlockStore::GetTreeIdentity(description, variable));
  return SealPages(file.data(), file.size(), "INTVTREE");
}

/// Puts the checksum of each segment right that the directory leads to.
void SealRecords(
  SealedBytes& records, const SealedBytes& directory, const BlockGrid& grid, std::uint32_t segments)
{
  const auto levels = static_cast<std::uint32_t>(grid.GetNumberOfLevels());
  const std::size_t entrySize = 16 + std::size_t{ 4 } * segments;
  const std::size_t perPage = (PageSize - 8) / entrySize;
  for (std::size_t ordinal = 0; (ordinal / perPage + 2) * PageSize <= directory.size(); ++ordinal)
  {
    const std::uint8_t* entry =
      directory.data() + (1 + ordinal / perPage) * PageSize + ordinal % perPage * entrySize;
    const auto block = LoadLittleEndian<std::int64_t>(entry);
    auto offset = LoadLittleEndian<std::uint64_t>(entry + 8);
    for (std::uint32_t segment = 0; segment < segments; ++segment)
    {
      const auto stored = LoadLittleEndian<std::uint32_t>(entry + 16 + std::size_t{ 4 } * segment);
      if (offset > records.size() || std::uint64_t{ 16 } + stored > records.size() - offset)
      {
        break;
      }
      SealSegmentBytes(
        records.data() + offset, stored, block, segment / levels, levels - 1 - segment % levels);
      offset += std::uint64_t{ 16 } + stored;
    }
  }
}

void ReadBlocks(const BlockStore& store, const BlockedVolumeHeader& header, const BlockGrid& grid)
{
  QueryStatistics statistics;
  for (std::uint32_t ordinal = 0; ordinal < std::min(store.GetNumberOfBlocks(), BlockLimit);
       ++ordinal)
  {
    const auto block = store.FindBlock(ordinal, statistics);
    if (!block.IsOk())
    {
      continue;
    }
    Require(*block >= 0 && *block < grid.GetNumberOfBlocks(), "a store's block is in the volume");
    const std::vector<ValueType> types = header.GetVariables().GetStoredTypes();
    for (int level = 0; level < grid.GetNumberOfLevels(); ++level)
    {
      const auto samples =
        static_cast<std::size_t>(grid.GetGhostedVertices(*block, level).GetNumberOfVertices());
      for (std::size_t component = 0; component < types.size(); ++component)
      {
        const auto decoded = store.ReadAdjacent(ordinal, *block, component, 1, level, statistics);
        Require(!decoded.IsOk() ||
            decoded->front()->Bytes.GetSize() == samples * GetValueSize(types[component]),
          "a decoded block has the samples of its box");
      }
      const auto all = store.ReadAdjacent(ordinal, *block, 0, types.size(), level, statistics);
      Require(!all.IsOk() ||
          MakeMagnitudeBlock(*all)->Bytes.GetSize() == samples * GetValueSize(ValueType::Float64),
        "a magnitude has the samples of its components' box");
    }
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < PrefixSize)
  {
    return 0;
  }
  const bool isSealed = (bytes[0] & 1) != 0;
  const BlockedVolumeHeader header = MakeHeader(bytes);
  const BlockGrid grid = header.GetBlockGrid();
  const auto blocks = static_cast<std::uint32_t>(grid.GetNumberOfBlocks());
  const ArrayVariables variables = header.GetVariables();
  const auto segments = static_cast<std::uint32_t>(variables.GetNumberOfStored()) *
    static_cast<std::uint32_t>(grid.GetNumberOfLevels());
  const std::size_t perPage = (PageSize - 8) / (16 + std::size_t{ 4 } * segments);
  const std::size_t treePages = bytes[6];
  const auto isovalue = LoadLittleEndian<double>(bytes + 7);

  const std::uint8_t* at = bytes + PrefixSize;
  SealedBytes directory = Take(at, bytes + size, (1 + (blocks + perPage - 1) / perPage) * PageSize);
  SealedBytes tree = Take(at, bytes + size, treePages * PageSize);
  SealedBytes records(at, bytes + size);
  if (isSealed)
  {
    directory = SealDirectory(std::move(directory), blocks, segments);
    SealRecords(records, directory, grid, segments);
  }
  const std::size_t pageBytes = directory.size() + tree.size();
  const StoreDescription description = { blocks, records.size(), Checksum };
  MemoryDisk disk;
  PutFile(disk, BlockStore::GetDirectoryPath(Folder), std::move(directory));
  const std::size_t last = variables.GetCount() - 1;
  for (const std::size_t variable : { last, std::size_t{ 0 } })
  {
    PutFile(disk, BlockStore::GetTreePath(Folder, variables, variable),
      isSealed ? SealTree(tree, description, variable) : tree);
  }
  PutFile(disk, StoreRecords::GetPath(Folder), std::move(records));

  // The page caches, a record's part and its samples, a query's node.
  const std::size_t edge = static_cast<std::size_t>(header.BlockSize) + 3;
  const MemoryLimit limit(3 * pageBytes +
    (3 + 2 * variables.GetCount()) * edge * edge * edge * sizeof(double) +
    std::size_t{ 256 } * 1024);
  const auto store = BlockStore::Open(disk, Folder, header, description);
  if (!store.IsOk())
  {
    return 0;
  }
  QueryStatistics statistics;
  for (const std::size_t variable : { std::size_t{ 0 }, last })
  {
    const auto active = (*store)->FindActive(variable, { isovalue, -isovalue, 0.5 }, statistics);
    for (std::size_t index = 0; active.IsOk() && index < active->size(); ++index)
    {
      const auto block = (*store)->FindBlock((*active)[index], statistics);
      Require(
        !block.IsOk() || *block < grid.GetNumberOfBlocks(), "an active block is in the volume");
    }
  }
  ReadBlocks(**store, header, grid);
  return 0;
}
