// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/VolumePlan.h"

#include "Ground/Volume/BlockGrid.h"
#include "Storage/Record/BlockRecord.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace isosurface
{
namespace
{

/// Levels in the records of a volume of several blocks. With two, an overview is 1/64 of the
/// volume (Documentation/dev/levels.md).
constexpr int LevelsBelowOverview = 2;

/// An overview has a store for every so many blocks, since each costs files.
constexpr std::int64_t BlocksPerOverviewStore = 64;

/// A time with the fewest digits that read back exactly.
std::string FormatTime(double time)
{
  char text[32];
  int digits = 1;
  do
  {
    std::snprintf(text, sizeof(text), "%.*g", digits, time);
  } while (std::strtod(text, nullptr) != time && ++digits <= 17);
  return text;
}

/// Why a time step does not continue the volume, or "".
std::string FindObstacle(const BlockedVolumeHeader& existing, const BlockedVolumeHeader& header,
  const std::optional<double>& time, bool isInPlace)
{
  const BlockCompression& compression = existing.Compression;
  const auto isSameArray = [](const ArrayDescription& a, const ArrayDescription& b)
  { return a.Name == b.Name && a.Type == b.Type && a.Components == b.Components; };
  std::string reason;
  if (existing.Grid.Extent == header.Grid.Extent && existing.Lines != header.Lines)
  {
    reason = "its grid lines are at other coordinates";
  }
  else if (existing.Grid != header.Grid)
  {
    reason = "it has another extent, origin, spacing or direction";
  }
  else if (existing.Grid.Unit != header.Grid.Unit && existing.Grid.Unit != LengthUnit::Unknown &&
    header.Grid.Unit != LengthUnit::Unknown)
  {
    reason = std::string("its coordinates are in ") + GetLengthUnitName(existing.Grid.Unit) +
      ", and not in " + GetLengthUnitName(header.Grid.Unit);
  }
  else if (!std::equal(existing.Arrays.begin(), existing.Arrays.end(), header.Arrays.begin(),
             header.Arrays.end(), isSameArray))
  {
    reason = "it has arrays of other names, types or numbers of components, or in another order";
  }
  else if (existing.BlockSize != header.BlockSize)
  {
    reason = "its blocks have " + std::to_string(existing.BlockSize) + " cells a side";
  }
  else if (existing.NumberOfStores != header.NumberOfStores)
  {
    reason = "it has " + std::to_string(existing.NumberOfStores) + " stores";
  }
  else if (existing.NumberOfReplicas != header.NumberOfReplicas)
  {
    reason =
      "it has each block in " + std::to_string(existing.NumberOfReplicas) + " stores (--replicas)";
  }
  else if (existing.Distribution != header.Distribution || existing.RandomSeed != header.RandomSeed)
  {
    reason = std::string("its blocks are distributed otherwise: ") +
      GetDistributionName(existing.Distribution) + ", seed " + std::to_string(existing.RandomSeed);
  }
  else if (compression.Codec != header.Compression.Codec ||
    compression.GetEffectiveLevel() != header.Compression.GetEffectiveLevel())
  {
    reason = std::string("it is compressed otherwise: ") + GetCodecName(compression.Codec) +
      ", level " + std::to_string(compression.GetEffectiveLevel());
  }
  else if (existing.IsInPlace() != isInPlace)
  {
    reason = isInPlace
      ? "it has copies of its samples, and this time step is to be indexed in place"
      : "it is indexed in place, and this time step is not (--in-place)";
  }
  else if (!existing.TimeSteps.back().Time)
  {
    reason = "its time step has no time";
  }
  else if (!(*existing.TimeSteps.back().Time < *time))
  {
    reason = "its last time step is that of time " + FormatTime(*existing.TimeSteps.back().Time) +
      ", this one of time " + FormatTime(*time) + "; times must ascend";
  }
  return reason;
}

/// In place, level 0 is not stored, so all others are those of overviews.
void PlanLevels(BlockedVolumeHeader& header, bool isInPlace)
{
  GridGeometry geometry = header.Grid;
  BlockGrid grid = header.GetBlockGrid();
  if (isInPlace || grid.GetNumberOfBlocks() > 1)
  {
    header.NumberOfLevels = isInPlace ? 1 : LevelsBelowOverview;
  }
  int levels = header.NumberOfLevels;
  while (grid.GetNumberOfBlocks() > 1)
  {
    geometry = geometry.Coarsen(levels);
    levels = LevelsBelowOverview;
    grid = BlockGrid(geometry.GetDimensions(), header.BlockSize);
    const std::int64_t blocks = grid.GetNumberOfBlocks();
    // Each replica of a block is in another store.
    const std::uint32_t stores =
      std::max(static_cast<std::uint32_t>((blocks - 1) / BlocksPerOverviewStore + 1),
        header.NumberOfReplicas);
    header.Overviews.push_back({ blocks > 1 ? LevelsBelowOverview : grid.GetNumberOfLevels(),
      std::min(header.NumberOfStores, stores) });
  }
}

} // namespace

Result<std::optional<BlockedVolumeHeader>> FindVolumeToAppendTo(FileSystem& files,
  const std::string& path, const BlockedVolumeSettings& settings,
  const std::optional<BlockedVolumeHeader>& pending)
{
  if (!settings.Append)
  {
    return std::optional<BlockedVolumeHeader>();
  }
  if (!settings.Time)
  {
    return Status(StatusCode::InvalidArgument,
      path +
        ": cannot be appended to: the time step has no time: give it one (--time), or write a "
        "series with WriteAllTimeSteps");
  }
  if (pending || !files.Exists(path))
  {
    return pending;
  }
  const auto existing = BlockedVolumeHeader::Read(files, path);
  return existing.IsOk() ? Result<std::optional<BlockedVolumeHeader>>(*existing)
                         : existing.GetStatus();
}

namespace
{

/// One for each rank, as far as so many are allowed.
std::uint32_t ChooseStores(
  const GridGeometry& grid, const BlockedVolumeSettings& settings, std::size_t ranks)
{
  const bool isValid = IsBlockSize(settings.BlockSize) && grid.GetNumberOfVertices() > 0;
  const std::int64_t limit = isValid ? BlockedVolumeHeader::GetStoreLimit(grid, settings.BlockSize)
                                     : BlockedVolumeHeader::StoresOfAnyVolume;
  return static_cast<std::uint32_t>(
    std::min<std::uint64_t>(ranks, static_cast<std::uint64_t>(limit)));
}

/// The bytes of a grid's records before compression.
std::uint64_t CountGridBytes(const BlockGrid& grid, const std::vector<ValueType>& types)
{
  // On an axis, blocks that are neither the first nor one of the last two are like the second. The
  // last can be too thin to give the one before it all levels.
  const Index3& blocks = grid.GetNumberOfBlocksPerAxis();
  Index3 kinds;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    kinds[axis] = std::min<std::int64_t>(4, blocks[axis]);
  }
  std::uint64_t bytes = 0;
  VisitVertices({ { 0, 0, 0 }, kinds },
    [&](const Index3& kind)
    {
      Index3 block = kind;
      std::int64_t alike = 1;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        block[axis] = kind[axis] < 2 ? kind[axis] : blocks[axis] - kinds[axis] + kind[axis];
        alike *= kind[axis] == 1 ? std::max<std::int64_t>(1, blocks[axis] - 3) : 1;
      }
      const BlockRecordLayout layout(grid, grid.GetBlockIndex(block), types);
      bytes += static_cast<std::uint64_t>(alike) * BlockRecord::AlignUp(layout.Size);
    });
  return bytes;
}

} // namespace

Result<BlockedVolumeHeader> PlanVolume(const std::string& path, const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const BlockedVolumeSettings& settings,
  const std::optional<BlockedVolumeHeader>& existing, std::size_t ranks)
{
  BlockedVolumeHeader header;
  header.Grid = grid;
  header.Lines = settings.Lines;
  header.FrameGrid();
  if (existing && existing->Lines && existing->Lines == header.Lines &&
    existing->Grid.Extent == header.Grid.Extent)
  {
    // Lines alone say where a rectilinear grid is.
    header.Grid = existing->Grid;
    header.Grid.Unit = grid.Unit;
  }
  header.BlockSize = settings.BlockSize;
  header.NumberOfStores = settings.NumberOfStores != 0 ? settings.NumberOfStores
    : existing                                         ? existing->NumberOfStores
                                                       : ChooseStores(grid, settings, ranks);
  header.NumberOfReplicas = settings.NumberOfReplicas != 0 ? settings.NumberOfReplicas
    : existing                                             ? existing->NumberOfReplicas
                                                           : 1;
  header.Distribution = settings.Distribution;
  header.RandomSeed = settings.RandomSeed;
  header.Compression = settings.Compression;
  header.Arrays = arrays;
  const Status valid = header.ValidateVolume();
  if (!valid.IsOk())
  {
    return Status(valid.GetCode(), path + ": cannot be written: " + valid.GetMessage());
  }
  if (settings.InPlace)
  {
    const Status source = settings.InPlace->Validate();
    if (!source.IsOk())
    {
      return Status(source.GetCode(), path + ": cannot be written: " + source.GetMessage());
    }
    if (!settings.InPlace->Chunk)
    {
      return Status(StatusCode::Unsupported,
        settings.InPlace->AbsolutePath +
          ": cannot be indexed in place: its samples are a compressed stream, which can only be "
          "read in order; copy it, without --in-place");
    }
  }
  if (existing)
  {
    const std::string obstacle =
      FindObstacle(*existing, header, settings.Time, settings.InPlace.has_value());
    if (!obstacle.empty())
    {
      return Status(StatusCode::InvalidArgument, path + ": cannot be appended to: " + obstacle);
    }
    if (header.Grid.Unit == LengthUnit::Unknown)
    {
      header.Grid.Unit = existing->Grid.Unit;
    }
    header.NumberOfLevels = existing->NumberOfLevels;
    header.Overviews = existing->Overviews;
    header.TimeSteps = existing->TimeSteps;
  }
  else
  {
    PlanLevels(header, settings.InPlace.has_value());
  }
  header.TimeSteps.emplace_back();
  header.TimeSteps.back().Time = settings.Time;
  header.TimeSteps.back().Source = settings.InPlace;
  header.TimeSteps.back().CopyOf = settings.CopyOf;
  header.TimeSteps.back().Overviews.resize(header.Overviews.size());
  return header;
}

std::uint64_t CountRecordBytes(const BlockedVolumeHeader& planned)
{
  const std::vector<ValueType> types = planned.GetVariables().GetStoredTypes();
  BlockGrid grid = planned.GetBlockGrid();
  GridGeometry geometry = planned.Grid;
  // In place, the volume's own samples are not stored.
  std::uint64_t bytes = planned.IsInPlace() ? 0 : CountGridBytes(grid, types);
  for (const OverviewDescription& overview : planned.Overviews)
  {
    geometry = geometry.Coarsen(grid.GetNumberOfLevels());
    grid = BlockGrid(geometry.GetDimensions(), planned.BlockSize, overview.NumberOfLevels);
    bytes += CountGridBytes(grid, types);
  }
  return bytes * planned.NumberOfReplicas;
}

} // namespace isosurface
