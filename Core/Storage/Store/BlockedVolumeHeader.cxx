// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockedVolumeHeader.h"

#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/JsonDocument.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

namespace isosurface
{
namespace
{

/// So that three numbers a vertex (its grid edges) fit 63 bits.
constexpr double MaximumVertices = 1152921504606846976.0; // 2^60

Status MakeMemberError(const char* member, const std::string& reason)
{
  return Status(StatusCode::InvalidArgument, std::string("member ") + member + " " + reason);
}

/// For what a user may have given: so a writer can report it, too.
Status MakeVolumeError(const std::string& reason)
{
  return Status(StatusCode::InvalidArgument, reason);
}

Status ValidateGrid(const GridGeometry& grid)
{
  double vertices = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t low = grid.Extent[2 * axis];
    const std::int64_t high = grid.Extent[2 * axis + 1];
    if (low < -BlockedVolumeHeader::MaximumCoordinate ||
      high > BlockedVolumeHeader::MaximumCoordinate || low > high)
    {
      return MakeVolumeError("the grid is empty, or its extent is beyond 2^40");
    }
    vertices *= static_cast<double>(high - low + 1);
  }
  if (vertices > MaximumVertices)
  {
    return MakeVolumeError("the grid has more than 2^60 vertices");
  }
  const char* fault = grid.FindFault();
  return fault ? MakeVolumeError(std::string("the grid ") + fault) : Status::Ok();
}

Status ValidateLines(const GridGeometry& grid, const GridLines& lines)
{
  ISOSURFACE_RETURN_IF_ERROR(lines.Check(grid.GetDimensions()));
  return grid.Direction == GridGeometry().Direction
    ? Status::Ok()
    : MakeVolumeError("the grid is rectilinear, and has a direction");
}

Status ValidateStores(
  const char* member, const std::vector<StoreDescription>& stores, std::uint64_t expected)
{
  std::uint64_t blocks = 0;
  for (const StoreDescription& store : stores)
  {
    if (store.Blocks > expected - blocks || store.Bytes % BlockRecord::Alignment != 0 ||
      store.Bytes >> 62 != 0)
    {
      return MakeMemberError(member, "has impossible numbers of blocks or bytes");
    }
    blocks += store.Blocks;
  }
  return blocks == expected ? Status::Ok()
                            : MakeMemberError(member, "does not have as many blocks as the volume");
}

Status ValidateTimeStep(const TimeStepDescription& step, const BlockedVolumeHeader& header)
{
  if (step.Time && !std::isfinite(*step.Time))
  {
    return MakeMemberError("timeSteps[].time", "is not finite");
  }
  if (step.Folder.size() < 6 || step.Folder.size() > 18 ||
    step.Folder.find_first_not_of("0123456789") != std::string::npos)
  {
    return MakeMemberError("timeSteps[].folder", "is not a number of 6 to 18 digits");
  }
  if (step.Ranges.size() != header.GetVariables().GetCount() ||
    step.Stores.size() != header.NumberOfStores || step.Overviews.size() != header.Overviews.size())
  {
    return MakeMemberError(
      "timeSteps[]", "does not fit the numbers of arrays, stores and overviews");
  }
  return ValidateStores("timeSteps[].stores", step.Stores,
    static_cast<std::uint64_t>(header.GetBlockGrid().GetNumberOfBlocks()));
}

/// All time steps have their samples in sources, or none has.
Status ValidateSources(const BlockedVolumeHeader& header)
{
  for (const TimeStepDescription& step : header.TimeSteps)
  {
    if (step.Source.has_value() != header.IsInPlace())
    {
      return MakeMemberError("timeSteps[].source", "is not there for all time steps");
    }
    for (const std::optional<SourceRecord>& record : { step.Source, step.CopyOf })
    {
      if (record && record->Arrays.size() != header.Arrays.size())
      {
        return MakeMemberError("timeSteps[].source.arrays", "does not fit the number of arrays");
      }
      ISOSURFACE_RETURN_IF_ERROR(record ? record->Validate() : Status::Ok());
    }
    if (step.Source && !step.Source->Chunk)
    {
      return MakeMemberError("timeSteps[].source.chunk", "is missing");
    }
  }
  return header.IsInPlace() && header.NumberOfLevels != 1
    ? MakeMemberError("numberOfLevels", "is not 1, as it is where the samples are in sources")
    : Status::Ok();
}

/// A store has at most one replica of a block.
Status ValidateReplicas(std::uint32_t replicas, std::uint32_t stores)
{
  if (replicas < 1 || replicas > BlockedVolumeHeader::MaximumReplicas)
  {
    return MakeVolumeError("the number of replicas, " + std::to_string(replicas) +
      ", is not from 1 to " + std::to_string(BlockedVolumeHeader::MaximumReplicas));
  }
  // Each replica costs memory when all are checked.
  if (replicas > 1 && std::int64_t{ replicas } * stores > BlockedVolumeHeader::MaximumStores)
  {
    return MakeVolumeError("the number of replicas times that of stores is above 2^20");
  }
  return replicas <= stores
    ? Status::Ok()
    : MakeVolumeError(std::to_string(replicas) + " replicas take as many stores; there are " +
        std::to_string(stores));
}

/// An overview is made of a volume of several blocks, and it has all blocks in its stores.
Status ValidateOverviews(const BlockedVolumeHeader& header)
{
  BlockGrid finer = header.GetBlockGrid();
  for (std::size_t index = 0; index < header.Overviews.size(); ++index)
  {
    const OverviewDescription& overview = header.Overviews[index];
    if (overview.NumberOfLevels < 1 ||
      overview.NumberOfLevels > GetMaximumNumberOfLevels(header.BlockSize) ||
      overview.NumberOfStores < 1 || overview.NumberOfStores > header.NumberOfStores)
    {
      return MakeMemberError("overviews", "has impossible numbers of levels or stores");
    }
    ISOSURFACE_RETURN_IF_ERROR(ValidateReplicas(header.NumberOfReplicas, overview.NumberOfStores));
    if (finer.GetNumberOfBlocks() == 1)
    {
      return MakeMemberError("overviews", "has an overview of a single block");
    }
    Index3 dimensions = finer.GetDimensions();
    for (std::int64_t& vertices : dimensions)
    {
      vertices = ((vertices - 1) >> finer.GetNumberOfLevels()) + 1;
    }
    finer = BlockGrid(dimensions, header.BlockSize, overview.NumberOfLevels);
    for (const TimeStepDescription& step : header.TimeSteps)
    {
      if (step.Overviews[index].size() != overview.NumberOfStores)
      {
        return MakeMemberError("timeSteps[].overviews", "does not fit the number of stores");
      }
      ISOSURFACE_RETURN_IF_ERROR(ValidateStores("timeSteps[].overviews", step.Overviews[index],
        static_cast<std::uint64_t>(finer.GetNumberOfBlocks())));
    }
  }
  return Status::Ok();
}

} // namespace

std::optional<std::size_t> BlockedVolumeHeader::FindArray(const std::string& name) const
{
  for (std::size_t index = 0; index < this->Arrays.size(); ++index)
  {
    if (this->Arrays[index].Name == name)
    {
      return index;
    }
  }
  return std::nullopt;
}

bool BlockedVolumeHeader::HasFolder(const std::string& folder) const
{
  return std::any_of(this->TimeSteps.begin(), this->TimeSteps.end(),
    [&](const TimeStepDescription& step) { return step.Folder == folder; });
}

Status BlockedVolumeHeader::ValidateVolume() const
{
  ISOSURFACE_RETURN_IF_ERROR(ValidateGrid(this->Grid));
  if (this->Lines)
  {
    ISOSURFACE_RETURN_IF_ERROR(ValidateLines(this->Grid, *this->Lines));
  }
  if (!IsBlockSize(this->BlockSize))
  {
    return MakeVolumeError(
      "the block size, " + std::to_string(this->BlockSize) + ", is not 16, 32 or 64");
  }
  double blocks = 1;
  for (const std::int64_t vertices : this->Grid.GetDimensions())
  {
    blocks *= std::ceil(static_cast<double>(vertices) / this->BlockSize);
  }
  if (blocks > std::numeric_limits<std::uint32_t>::max())
  {
    return MakeVolumeError("the grid has more than 2^32 blocks: take a larger block size");
  }
  const std::int64_t storeLimit = GetStoreLimit(this->Grid, this->BlockSize);
  if (this->NumberOfStores < 1 || this->NumberOfStores > storeLimit)
  {
    return MakeVolumeError("the number of stores, " + std::to_string(this->NumberOfStores) +
      ", is not from 1 to " + std::to_string(storeLimit) + ", the maximum for so few blocks");
  }
  ISOSURFACE_RETURN_IF_ERROR(ValidateReplicas(this->NumberOfReplicas, this->NumberOfStores));
  if (!this->Compression.IsValid())
  {
    return MakeVolumeError("the compression level is beyond those of the codec");
  }
  std::set<std::string> names;
  std::size_t components = 0;
  for (const ArrayDescription& array : this->Arrays)
  {
    if (array.Components < 1)
    {
      return MakeVolumeError("array \"" + array.Name + "\" has no components");
    }
    components += static_cast<std::size_t>(array.Components);
    if (!names.insert(array.Name).second)
    {
      return MakeVolumeError("two arrays have the name \"" + array.Name + "\"");
    }
    if (!IsUtf8(array.Name))
    {
      return MakeVolumeError("the name of array \"" + array.Name + "\" is not UTF-8");
    }
    if (!IsUtf8(array.Unit))
    {
      return MakeVolumeError("the unit of array \"" + array.Name + "\" is not UTF-8");
    }
  }
  const int maximumLevels = GetMaximumNumberOfLevels(this->BlockSize);
  if (this->NumberOfLevels < 0 || this->NumberOfLevels > maximumLevels)
  {
    return MakeMemberError("numberOfLevels", "is not from 1 to " + std::to_string(maximumLevels));
  }
  // The coarsest overview has all levels that a block can have.
  const auto levels = static_cast<std::size_t>(maximumLevels);
  if (this->Arrays.empty() || components > BlockDirectory::MaximumSegments / levels)
  {
    return MakeVolumeError("the arrays do not have from 1 to " +
      std::to_string(BlockDirectory::MaximumSegments / levels) + " components in all");
  }
  return Status::Ok();
}

Status BlockedVolumeHeader::Validate() const
{
  ISOSURFACE_RETURN_IF_ERROR(this->ValidateVolume());
  if (this->TimeSteps.empty())
  {
    return MakeMemberError("timeSteps", "has no element");
  }
  const TimeStepDescription* before = nullptr;
  for (const TimeStepDescription& step : this->TimeSteps)
  {
    ISOSURFACE_RETURN_IF_ERROR(ValidateTimeStep(step, *this));
    if (this->TimeSteps.size() > 1 && (!step.Time || (before && !(*before->Time < *step.Time))))
    {
      return MakeMemberError("timeSteps[].time", "is not above that of the time step before");
    }
    before = &step;
  }
  ISOSURFACE_RETURN_IF_ERROR(ValidateSources(*this));
  return ValidateOverviews(*this);
}

std::int64_t BlockedVolumeHeader::GetStoreLimit(const GridGeometry& grid, int blockSize)
{
  const std::int64_t blocks = BlockGrid(grid.GetDimensions(), blockSize).GetNumberOfBlocks();
  return std::min(MaximumStores, std::max(StoresOfAnyVolume, blocks));
}

void BlockedVolumeHeader::FrameGrid()
{
  if (this->Lines && this->Lines->Check(this->Grid.GetDimensions()).IsOk())
  {
    this->Grid.Direction = GridGeometry().Direction;
    this->Grid = this->Lines->MakeFrame(this->Grid, { { 0, 0, 0 }, this->Grid.GetDimensions() });
  }
}

BlockGrid BlockedVolumeHeader::GetBlockGrid() const
{
  return BlockGrid(this->Grid.GetDimensions(), this->BlockSize, this->NumberOfLevels);
}

BlockedVolumeHeader BlockedVolumeHeader::MakeOverview(std::size_t overview) const
{
  int level = this->GetBlockGrid().GetNumberOfLevels();
  for (std::size_t finer = 0; finer < overview; ++finer)
  {
    level += this->Overviews[finer].NumberOfLevels;
  }
  // A copy of all would have the descriptions of all stores for a while.
  BlockedVolumeHeader header;
  header.Grid = this->Grid.Coarsen(level);
  if (this->Lines)
  {
    header.Lines = this->Lines->Coarsen(level);
  }
  header.BlockSize = this->BlockSize;
  header.NumberOfLevels = this->Overviews[overview].NumberOfLevels;
  header.NumberOfStores = this->Overviews[overview].NumberOfStores;
  header.NumberOfReplicas = this->NumberOfReplicas;
  header.Distribution = this->Distribution;
  header.RandomSeed = this->RandomSeed;
  header.Compression = this->Compression;
  header.Arrays = this->Arrays;
  for (const TimeStepDescription& step : this->TimeSteps)
  {
    TimeStepDescription& own = header.TimeSteps.emplace_back();
    own.Time = step.Time;
    own.Folder = GetOverviewFolder(step.Folder, overview);
    own.Ranges = step.Ranges;
    own.Stores = step.Overviews[overview];
    own.CopyOf = step.CopyOf;
  }
  return header;
}

std::string GetStoresFolder(FileSystem& files, const std::string& path)
{
  const std::string shown = path + ".stores";
  return files.Exists(shown) ? shown : HidePath(shown);
}

std::string GetOverviewFolder(const std::string& generation, std::size_t overview)
{
  return generation + "/overview-" + std::to_string(overview + 1);
}

std::string GetStoreFolder(
  FileSystem& files, const std::string& path, const std::string& generation, std::uint32_t store)
{
  char name[32];
  std::snprintf(name, sizeof(name), "/store-%05u", store);
  return GetStoresFolder(files, path) + "/" + generation + name;
}

std::string GetReplicaFolder(FileSystem& files, const std::string& path,
  const std::string& generation, std::uint32_t store, std::uint32_t replica, std::uint32_t stores)
{
  const std::string folder =
    GetStoreFolder(files, path, generation, FindHost(store, replica, stores));
  return replica == 0 ? folder : folder + "/replica-" + std::to_string(replica);
}

} // namespace isosurface
