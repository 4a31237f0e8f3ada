// SPDX-License-Identifier: BSD-3-Clause
#include "Writing/BlockedVolumeWriteJob.h"

#include "Base/Checksum.h"
#include "Base/Coding.h"
#include "Base/ParallelFor.h"
#include "Partition/BlockBalancer.h"
#include "Partition/BlockDistribution.h"
#include "Record/BlockRecord.h"
#include "Record/RecordCodec.h"
#include "Store/VolumeSpectra.h"
#include "Writing/BlockRounds.h"
#include "Writing/BlockShipment.h"
#include "Writing/GenerationFolder.h"
#include "Writing/OverviewSamples.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace isosurface
{
namespace
{

/// The shares of the work that are done when ranges are known, and when blocks are written.
constexpr double RangesDone = 0.25;
constexpr double BlocksDone = 0.95;
constexpr double StoresDone = 0.97;

/// Sorting a store's intervals is not worth more.
constexpr std::uint64_t LargestTreeBytes = std::uint64_t{ 64 } << 20;

/// The levels that the records of a volume's blocks hold; the next one is an overview's. With two,
/// an overview is 1/64 of the volume: Documentation/dev/levels.md.
constexpr int LevelsBelowOverview = 2;

/// A store of an overview with fewer blocks is not worth its files.
constexpr std::int64_t BlocksPerOverviewStore = 64;

/// With as many digits as tell a time from any other.
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

} // namespace

Status BlockedVolumeWriteJob::AgreeOn(const Status& mine)
{
  std::vector<std::uint64_t> aborted = { mine.GetCode() == StatusCode::Aborted ? 1u : 0u };
  this->Ranks.ReduceMaximum(aborted);
  const Status all = this->Ranks.Agree(mine);
  return aborted[0] != 0 ? this->MakeAborted() : all;
}

Result<WriteStatistics> BlockedVolumeWriteJob::Run(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& pending)
{
  // First of all, so that a second writer fails before it works in vain.
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Rank == 0 ? this->LockVolume() : Status::Ok()));
  const Status status = this->WriteVolume(grid, arrays, pending);
  if (!status.IsOk())
  {
    this->Writers.clear();
    this->OverviewSamples.reset();
    // Every rank has closed its files before their folder is removed.
    static_cast<void>(this->Ranks.Agree(Status::Ok()));
    if (this->Rank == 0 && !this->IsVisible)
    {
      GenerationFolder::Discard(this->Files, this->Path, this->NewFolder);
    }
    return status;
  }
  return this->Statistics;
}

/// Keeps other writers out until this job ends.
Status BlockedVolumeWriteJob::LockVolume()
{
  if (this->Lock)
  {
    return Status::Ok();
  }
  auto lock = this->Files.LockFolder(GetStoresFolder(this->Path));
  if (lock.IsOk())
  {
    this->Lock = std::move(*lock);
  }
  return lock.GetStatus();
}

Status BlockedVolumeWriteJob::WriteVolume(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& pending)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Prepare(grid, arrays, pending));
  ISOSURFACE_RETURN_IF_ERROR(this->FindRanges());
  ISOSURFACE_RETURN_IF_ERROR(this->MakeGeneration());
  ISOSURFACE_RETURN_IF_ERROR(this->CreateStores());
  ISOSURFACE_RETURN_IF_ERROR(this->WriteBlocks());
  ISOSURFACE_RETURN_IF_ERROR(this->FinishStores());
  ISOSURFACE_RETURN_IF_ERROR(this->WriteOverviews());
  return this->Commit();
}

/// `header`: the overview as a volume of its own, its last time step the one that is written.
Status BlockedVolumeWriteJob::RunOverview(const BlockedVolumeHeader& header, bool hasCoarser)
{
  this->Header = header;
  this->HasCoarser = hasCoarser;
  ISOSURFACE_RETURN_IF_ERROR(this->PrepareBlocks());
  ISOSURFACE_RETURN_IF_ERROR(this->FindRanges());
  // Those of the volume, so that all spectra have the same bins.
  this->GetStep().Ranges = header.TimeSteps.back().Ranges;
  ISOSURFACE_RETURN_IF_ERROR(this->CreateStores());
  ISOSURFACE_RETURN_IF_ERROR(this->WriteBlocks());
  return this->FinishStores();
}

Status BlockedVolumeWriteJob::Prepare(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& pending)
{
  const auto existing = this->FindVolumeToAppendTo(pending);
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(existing.GetStatus()));
  if (this->Settings.NumberOfStores == 0 && *existing)
  {
    this->Settings.NumberOfStores = (*existing)->NumberOfStores;
  }
  if (this->Settings.NumberOfStores == 0)
  {
    this->Settings.NumberOfStores = static_cast<std::uint32_t>(this->Size);
  }
  const int ranksOnNode = this->Ranks.GetRanksOnNode();
  if (this->Settings.Threads <= 0)
  {
    this->Settings.Threads = ChooseThreadCount(ranksOnNode);
  }
  this->Header.Grid = grid;
  this->Header.BlockSize = this->Settings.BlockSize;
  this->Header.NumberOfStores = this->Settings.NumberOfStores;
  this->Header.Distribution = this->Settings.Distribution;
  this->Header.RandomSeed = this->Settings.RandomSeed;
  this->Header.Compression = this->Settings.Compression;
  this->Header.Arrays = arrays;
  Status status = this->Header.ValidateVolume();
  if (!status.IsOk())
  {
    status = Status(status.GetCode(), this->Path + ": cannot be written: " + status.GetMessage());
  }
  if (status.IsOk())
  {
    status = this->CheckBox();
  }
  if (status.IsOk() && *existing)
  {
    status = this->CheckAppends(**existing);
    // Whichever version wrote the steps before, all have the same levels in the same places.
    this->Header.NumberOfLevels = (*existing)->NumberOfLevels;
    this->Header.Overviews = (*existing)->Overviews;
    this->Header.TimeSteps = (*existing)->TimeSteps;
  }
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(status));
  if (!*existing)
  {
    this->PlanLevels();
  }
  this->Header.TimeSteps.emplace_back();
  this->GetStep().Time = this->Settings.Time;
  ISOSURFACE_RETURN_IF_ERROR(this->CheckEqualArguments());
  this->HasCoarser = !this->Header.Overviews.empty();
  this->GetStep().Overviews.resize(this->Header.Overviews.size());
  return this->PrepareBlocks();
}

/// What the levels of a new volume are stored in: the first ones in the volume's blocks, the next
/// ones in those of an overview, and so on until an overview is a single block, which has the rest.
void BlockedVolumeWriteJob::PlanLevels()
{
  BlockedVolumeHeader& header = this->Header;
  GridGeometry geometry = header.Grid;
  BlockGrid grid = header.GetBlockGrid();
  if (grid.GetNumberOfBlocks() > 1)
  {
    header.NumberOfLevels = LevelsBelowOverview;
  }
  while (grid.GetNumberOfBlocks() > 1)
  {
    geometry = geometry.Coarsen(LevelsBelowOverview);
    grid = BlockGrid(geometry.GetDimensions(), header.BlockSize);
    const std::int64_t blocks = grid.GetNumberOfBlocks();
    const auto stores = static_cast<std::uint32_t>((blocks - 1) / BlocksPerOverviewStore + 1);
    header.Overviews.push_back({ blocks > 1 ? LevelsBelowOverview : grid.GetNumberOfLevels(),
      std::min(header.NumberOfStores, stores) });
  }
}

Status BlockedVolumeWriteJob::PrepareBlocks()
{
  this->Grid = this->Header.GetBlockGrid();
  this->Variables = this->Header.GetVariables();
  this->Types = this->Variables.GetStoredTypes();
  return this->ShareBoxes();
}

/// Nothing if the time step is the first one.
Result<std::optional<BlockedVolumeHeader>> BlockedVolumeWriteJob::FindVolumeToAppendTo(
  const std::optional<BlockedVolumeHeader>& pending) const
{
  if (!this->Settings.Append)
  {
    return std::optional<BlockedVolumeHeader>();
  }
  if (!this->Settings.Time)
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": cannot be appended to: the time step has no time");
  }
  if (pending || !this->Files.Exists(this->Path))
  {
    return pending;
  }
  const auto existing = BlockedVolumeHeader::Read(this->Files, this->Path);
  return existing.IsOk() ? Result<std::optional<BlockedVolumeHeader>>(*existing)
                         : existing.GetStatus();
}

/// Whether the time step goes on where the volume ends.
Status BlockedVolumeWriteJob::CheckAppends(const BlockedVolumeHeader& existing) const
{
  const BlockedVolumeHeader& header = this->Header;
  const BlockCompression& compression = existing.Compression;
  const auto isSameArray = [](const ArrayDescription& a, const ArrayDescription& b)
  { return a.Name == b.Name && a.Type == b.Type && a.Components == b.Components; };
  std::string reason;
  if (existing.Grid != header.Grid)
  {
    reason = "it has another extent, origin, spacing or direction";
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
  else if (!existing.TimeSteps.back().Time)
  {
    reason = "its time step has no time";
  }
  else if (!(*existing.TimeSteps.back().Time < *this->Settings.Time))
  {
    reason = "its last time step is that of time " + FormatTime(*existing.TimeSteps.back().Time) +
      ", this one of time " + FormatTime(*this->Settings.Time) + "; times must ascend";
  }
  return reason.empty()
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument, this->Path + ": cannot be appended to: " + reason);
}

Status BlockedVolumeWriteJob::CheckBox() const
{
  const VertexBox& box = this->Source.GetBox();
  const VertexBox whole = { { 0, 0, 0 }, this->Header.Grid.GetDimensions() };
  return box.IsEmpty() || whole.Intersect(box) == box
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument,
        this->Path + ": cannot be written: a rank's piece does not fit the grid");
}

Status BlockedVolumeWriteJob::CheckEqualArguments()
{
  // The header has all else that matters.
  const std::string text = this->Path + "\n" + this->Header.Format() + "\n" +
    std::to_string(this->Settings.MemoryLimit) + (this->Settings.Publish ? "" : "\n");
  const std::uint64_t hash = ComputeChecksum(text.data(), text.size());
  std::vector<std::uint64_t> least = { hash };
  std::vector<std::uint64_t> greatest = { hash };
  this->Ranks.ReduceMinimum(least);
  this->Ranks.ReduceMaximum(greatest);
  return least == greatest
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument,
        this->Path + ": cannot be written: the ranks disagree about grid, arrays or settings");
}

Status BlockedVolumeWriteJob::ShareBoxes()
{
  std::vector<std::int64_t> mine;
  for (const Index3& corner : { this->Source.GetBox().Low, this->Source.GetBox().High })
  {
    mine.insert(mine.end(), corner.begin(), corner.end());
  }
  Message message(mine.size() * sizeof(std::int64_t));
  for (std::size_t index = 0; index < mine.size(); ++index)
  {
    StoreLittleEndian(message.data() + 8 * index, mine[index]);
  }
  std::vector<VertexBox> boxes;
  for (const Message& other : this->Ranks.AllGather(message))
  {
    VertexBox box;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box.Low[axis] = LoadLittleEndian<std::int64_t>(other.data() + 8 * axis);
      box.High[axis] = LoadLittleEndian<std::int64_t>(other.data() + 24 + 8 * axis);
    }
    boxes.push_back(box);
  }
  this->Exchange.emplace(this->Grid, this->Types, boxes, this->Rank, this->Settings.Threads);
  this->Plan.emplace(this->Grid, this->Size);
  std::vector<std::uint64_t> covered = { 0 };
  for (const VertexBox& box : this->Exchange->GetOwned())
  {
    covered[0] += static_cast<std::uint64_t>(box.GetNumberOfVertices());
  }
  this->Ranks.ReduceSum(covered);
  const auto all = static_cast<std::uint64_t>(this->Header.Grid.GetNumberOfVertices());
  return covered[0] == all
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument,
        this->Path + ": cannot be written: the ranks' pieces cover " + std::to_string(covered[0]) +
          " of " + std::to_string(all) + " vertices");
}

/// What is held for every block of the volume while the rounds go on, and each array's bins.
std::uint64_t BlockedVolumeWriteJob::GetTableBytes() const
{
  const auto blocks = static_cast<std::uint64_t>(this->Grid.GetNumberOfBlocks());
  // Ranges, twice more while they are joined; stores, and what distributing takes.
  constexpr std::uint64_t distributionBytes = 48;
  std::uint64_t bytes = blocks *
    (this->Variables.GetCount() * sizeof(KeyRange) + 3 * sizeof(KeyRange) + distributionBytes);
  if (this->Settings.Distribution == DistributionMethod::Balanced && this->BlockStores.empty())
  {
    bytes += BlockProfileScan::GetBytes(this->Grid) +
      BlockBalancer::GetBytes(this->Settings.NumberOfStores);
  }
  std::uint64_t mine = 0;
  for (const std::uint32_t store : this->BlockStores)
  {
    mine += this->IsMine(store) ? 1 : 0;
  }
  const std::size_t segments =
    this->Types.size() * static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  bytes += mine * BlockStoreWriter::GetEntryBytes(segments);
  if (this->Spectra)
  {
    bytes += this->Spectra->GetBytes();
  }
  return bytes + this->Source.GetHeldBytes();
}

/// What the threads need to work on a block each.
std::uint64_t BlockedVolumeWriteJob::GetThreadBytes() const
{
  const auto side = static_cast<std::uint64_t>(this->Settings.BlockSize) + 3;
  // A block as it is decoded and twice that for compressing it, or all components of a magnitude
  // and itself; and what counts for the spectra.
  std::uint64_t vertexBytes = 24;
  for (const ArrayDescription& array : this->Header.Arrays)
  {
    const auto components = static_cast<std::uint64_t>(array.Components);
    vertexBytes = std::max(vertexBytes, components * GetValueSize(array.Type) + sizeof(double));
  }
  const std::uint64_t bytes = side * side * side * vertexBytes +
    StoreSpectra::GetCounterBytes(
      this->Variables.GetCount(), static_cast<std::uint64_t>(this->Settings.BlockSize));
  return static_cast<std::uint64_t>(this->Settings.Threads) * bytes;
}

Result<std::uint64_t> BlockedVolumeWriteJob::GetMemoryLeft(std::uint64_t taken) const
{
  // A part is left to what no plan knows: the heap's own losses, stacks, files.
  const std::uint64_t usable = this->Settings.MemoryLimit - this->Settings.MemoryLimit / 8;
  if (taken >= usable)
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": cannot be written: the memory limit of " +
        std::to_string(this->Settings.MemoryLimit) + " bytes is too small: " +
        std::to_string(taken) + " are taken by tables of blocks, bins and threads alone");
  }
  return usable - taken;
}

Status BlockedVolumeWriteJob::FindRanges()
{
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Attempt(
    [&]() -> Status
    {
      const auto left = this->GetMemoryLeft(this->GetTableBytes());
      if (!left.IsOk())
      {
        return left.GetStatus();
      }
      this->Scan.emplace(this->Grid, this->Variables, this->Settings.Threads);
      if (this->Settings.Distribution == DistributionMethod::Balanced)
      {
        this->Scan->AddProfiles();
      }
      return this->Scan->Scan(this->Source, this->Exchange->GetOwned(), *left,
        [&](double share) { return this->TellShare(share * RangesDone); });
    })));
  this->Scan->Reduce(this->Ranks);
  this->GetStep().Ranges = this->Scan->GetFiniteRanges();
  return this->AgreeOn(this->Attempt(
    [&]
    {
      const std::size_t variable = *this->Variables.Find(0, Variable::Magnitude);
      this->BlockStores = DistributeBlocks(this->Settings.Distribution,
        this->Variables[variable].Type, this->Scan->GetRanges()[variable],
        this->Settings.NumberOfStores, this->Settings.RandomSeed, this->Scan->TakeProfiles());
      return Status::Ok();
    }));
}

Status BlockedVolumeWriteJob::MakeGeneration()
{
  Status status;
  Message name;
  if (this->Rank == 0)
  {
    if (this->Lock->IsExclusive())
    {
      GenerationFolder::RemoveUnnamed(this->Files, this->Path, this->Header);
    }
    const auto created = GenerationFolder::Create(this->Files, this->Path);
    status = created.GetStatus();
    if (created.IsOk())
    {
      this->NewFolder = *created;
      name.assign(created->begin(), created->end());
    }
  }
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(status));
  const Message shared = this->Ranks.AllGather(name)[0];
  this->GetStep().Folder.assign(shared.begin(), shared.end());
  return Status::Ok();
}

Status BlockedVolumeWriteJob::CreateStores()
{
  return this->AgreeOn(this->Attempt(
    [&]() -> Status
    {
      this->Writers.resize(this->Settings.NumberOfStores);
      std::vector<SpectrumBins> bins;
      for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
      {
        bins.push_back(
          SpectrumBins::Choose(this->Variables[variable].Type, this->GetStep().Ranges[variable]));
      }
      this->Spectra.emplace(this->Header.Grid, this->Variables, std::move(bins),
        this->Settings.NumberOfStores, this->Rank, this->Size);
      const std::size_t segments =
        this->Types.size() * static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
      std::vector<std::size_t> blocks(this->Settings.NumberOfStores, 0);
      for (const std::uint32_t store : this->BlockStores)
      {
        ++blocks[store];
      }
      for (std::uint32_t store = 0; store < this->Settings.NumberOfStores; ++store)
      {
        if (!this->IsMine(store))
        {
          continue;
        }
        auto writer = BlockStoreWriter::Create(this->Files,
          GetStoreFolder(this->Path, this->GetStep().Folder, store), segments, blocks[store]);
        if (!writer.IsOk())
        {
          return writer.GetStatus();
        }
        this->Writers[store] = std::move(*writer);
      }
      // A rank without stores has no folder there, and no blocks.
      if (this->HasCoarser && this->Rank < this->Settings.NumberOfStores)
      {
        auto samples =
          this->Files.CreateForWriting(OverviewSource::GetPath(this->GetFolder(), this->Rank));
        if (!samples.IsOk())
        {
          return samples.GetStatus();
        }
        this->OverviewSamples = std::move(*samples);
      }
      return Status::Ok();
    }));
}

Status BlockedVolumeWriteJob::WriteBlocks()
{
  const auto left = this->GetMemoryLeft(this->GetTableBytes() + this->GetThreadBytes());
  std::vector<std::vector<BlockCounters>> counters;
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(left.GetStatus()));
  // Rounds are planned alike on all ranks, so what the fullest one has left counts.
  std::vector<std::uint64_t> memory = { *left };
  this->Ranks.ReduceMinimum(memory);
  for (int thread = 0; thread < this->Settings.Threads; ++thread)
  {
    counters.push_back(this->Spectra->MakeCounters());
  }
  const BlockShipment shipment(this->Grid, this->Types, this->BlockStores, this->Rank, this->Size);
  BlockRounds rounds(this->Ranks, this->Source, this->Grid, this->Types, *this->Exchange, shipment,
    *this->Plan, this->Settings.Threads, memory[0]);
  BlockRoundsSteps steps;
  steps.Agree = [&](const Status& mine) { return this->AgreeOn(mine); };
  steps.Finish = [&](PendingBlock& block, const std::vector<SampleView>& views, int thread)
  { this->FinishBlock(block, views, counters[static_cast<std::size_t>(thread)]); };
  steps.Write = [&](const PendingBlock& block)
  {
    if (this->OverviewSamples)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->OverviewSamples->Append(block.OverviewSamples.data(), block.OverviewSamples.size()));
    }
    return this->Writers[block.Store]->Append(block);
  };
  steps.Tell = [&](double share)
  { return this->TellShare(RangesDone + (BlocksDone - RangesDone) * share); };
  const Status status = rounds.Run(steps);
  this->Statistics.Rounds = rounds.GetRounds();
  this->Statistics.MemoryBytes = this->Settings.MemoryLimit - memory[0] + rounds.GetLargestBytes();
  return status.IsOk() || status.GetCode() == StatusCode::Aborted
    ? status
    : Status(status.GetCode(), this->Path + ": cannot be written: " + status.GetMessage());
}

/// Counts what a filled block adds to the spectra, and makes its record what the file will have.
void BlockedVolumeWriteJob::FinishBlock(
  PendingBlock& block, const std::vector<SampleView>& views, std::vector<BlockCounters>& counters)
{
  const auto& ranges = this->Scan->GetRanges();
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    const KeyRange& range = ranges[variable][static_cast<std::size_t>(block.Block)];
    if (range.Minimum < range.Maximum)
    {
      if (variable < views.size())
      {
        counters[variable].Count(views[variable]);
      }
      else
      {
        counters[variable].Count(this->AssembleVariable(block, variable)->View);
      }
    }
    else
    {
      counters[variable].Measure.CountUniform(
        this->Variables[variable].Type, range.Minimum, this->Grid.GetVertices(block.Block));
    }
    this->Spectra->Add(block.Store, variable, counters[variable]);
  }
  if (this->OverviewSamples)
  {
    block.OverviewSamples = PickOverviewSamples(this->Grid, this->Types, block);
  }
  EncodeRecord(
    this->Settings.Compression, this->Grid, block.Block, this->Types, block.Layout, block.Record);
}

/// The samples of a filled block at full resolution.
std::shared_ptr<DecodedBlock> BlockedVolumeWriteJob::AssembleVariable(
  const PendingBlock& block, std::size_t variable) const
{
  const Variable& wanted = this->Variables[variable];
  if (wanted.IsMagnitude())
  {
    DecodedBlocks components;
    for (int component = 0; component < this->Variables.GetComponents(wanted.Array); ++component)
    {
      components.push_back(
        this->AssembleVariable(block, *this->Variables.Find(wanted.Array, component)));
    }
    return MakeMagnitudeBlock(components);
  }
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  std::vector<const std::uint8_t*> segments;
  for (std::size_t index = variable * levels; index < (variable + 1) * levels; ++index)
  {
    segments.push_back(
      block.Record.GetData() + block.Layout.Offsets[index] + BlockRecord::SegmentHeaderSize);
  }
  return AssembleLevel(this->Grid, block.Block, 0, wanted.Type, segments);
}

Status BlockedVolumeWriteJob::FinishStores()
{
  this->GetStep().Stores.resize(this->Settings.NumberOfStores);
  const Status status = this->Attempt(
    [&]() -> Status
    {
      std::vector<std::uint32_t> mine;
      for (std::uint32_t store = 0; store < this->Settings.NumberOfStores; ++store)
      {
        if (this->Writers[store])
        {
          mine.push_back(store);
        }
      }
      // Together, so that the disk is waited for once rather than once a store.
      const auto threads = std::min<std::size_t>(
        std::max<std::size_t>(1, mine.size()), static_cast<std::size_t>(this->Settings.Threads));
      const auto left = this->GetMemoryLeft(this->GetTableBytes());
      const std::size_t memory =
        static_cast<std::size_t>(left.IsOk() ? std::min(*left, LargestTreeBytes) : 0) / threads;
      std::vector<Status> outcomes(mine.size());
      const bool isDone = ParallelFor(
        mine.size(), static_cast<int>(threads),
        [&](std::size_t index, int)
        {
          std::unique_ptr<BlockStoreWriter>& writer = this->Writers[mine[index]];
          this->Spectra->FinishStore(mine[index], writer->GetEntries(), this->Scan->GetRanges());
          const auto description = writer->Finish(this->Variables, this->Scan->GetRanges(), memory);
          outcomes[index] = description.GetStatus();
          if (description.IsOk())
          {
            this->GetStep().Stores[mine[index]] = *description;
          }
          writer.reset();
        },
        [&](double share)
        { return this->TellShare(BlocksDone + (StoresDone - BlocksDone) * share); });
      for (const Status& outcome : outcomes)
      {
        ISOSURFACE_RETURN_IF_ERROR(outcome);
      }
      if (this->OverviewSamples)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->OverviewSamples->SyncAndClose());
        this->OverviewSamples.reset();
      }
      return isDone ? Status::Ok() : this->MakeAborted();
    });
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(status));
  this->ShareDescriptions();
  return this->ShareSpectra();
}

void BlockedVolumeWriteJob::ShareDescriptions()
{
  // A store is described by its writer, by zeros elsewhere.
  std::vector<std::uint64_t> values;
  for (const StoreDescription& store : this->GetStep().Stores)
  {
    values.insert(values.end(), { store.Blocks, store.Bytes, store.Checksum });
  }
  this->Ranks.ReduceSum(values);
  for (std::size_t store = 0; store < this->GetStep().Stores.size(); ++store)
  {
    this->GetStep().Stores[store] = { values[3 * store], values[3 * store + 1],
      values[3 * store + 2] };
    this->Statistics.Blocks += values[3 * store];
    this->Statistics.Bytes += values[3 * store + 1];
  }
  this->Statistics.Stores = this->GetStep().Stores;
}

/// Brings the spectra of all stores to rank 0, which writes them.
Status BlockedVolumeWriteJob::ShareSpectra()
{
  std::vector<Message> outgoing(this->Size);
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Attempt(
    [&]
    {
      outgoing[0] = this->Spectra->Pack();
      return Status::Ok();
    })));
  const std::vector<Message> incoming = this->Ranks.Exchange(std::move(outgoing));
  const std::vector<WorkloadSpectrum> totals = this->Spectra->ReduceTotals(this->Ranks);
  return this->AgreeOn(this->Attempt(
    [&]
    {
      return this->Rank != 0 ? Status::Ok()
                             : SpectraFile::Write(this->Files,
                                 VolumeSpectra::GetPath(this->Path, this->GetStep().Folder), totals,
                                 this->Spectra->Unpack(incoming));
    }));
}

/// Each overview is written as the volume was, from the samples that writing the one before it
/// left.
Status BlockedVolumeWriteJob::WriteOverviews()
{
  std::unique_ptr<BlockedVolumeWriteJob> coarsest;
  for (std::size_t overview = 0; overview < this->Header.Overviews.size(); ++overview)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->WriteOverview(overview, coarsest));
  }
  return Status::Ok();
}

/// `coarsest`: the job of the overview before, null for none; then that of the one written.
Status BlockedVolumeWriteJob::WriteOverview(
  std::size_t overview, std::unique_ptr<BlockedVolumeWriteJob>& coarsest)
{
  BlockedVolumeWriteJob& finer = coarsest ? *coarsest : *this;
  std::optional<OverviewSource> source;
  std::unique_ptr<BlockedVolumeWriteJob> job;
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Attempt(
    [&]
    {
      finer.Scan.reset();
      finer.Spectra.reset();
      source.emplace(this->Files, finer.GetFolder(), finer.Grid, this->Types,
        std::move(finer.BlockStores), this->Size);
      BlockedVolumeSettings settings = this->Settings;
      settings.NumberOfStores = this->Header.Overviews[overview].NumberOfStores;
      job = std::make_unique<BlockedVolumeWriteJob>(this->Ranks, this->Files, this->Path, *source,
        settings,
        [&](double share) { return this->TellShare(StoresDone + (1 - StoresDone) * share); });
      return Status::Ok();
    })));
  ISOSURFACE_RETURN_IF_ERROR(job->RunOverview(
    this->Header.MakeOverview(overview), overview + 1 < this->Header.Overviews.size()));
  ISOSURFACE_RETURN_IF_ERROR(finer.RemoveOverviewSamples());
  this->GetStep().Overviews[overview] = job->GetStep().Stores;
  this->Statistics.OverviewBytes += job->Statistics.Bytes;
  this->Statistics.MemoryBytes =
    std::max(this->Statistics.MemoryBytes, job->Statistics.MemoryBytes);
  coarsest = std::move(job);
  return Status::Ok();
}

Status BlockedVolumeWriteJob::RemoveOverviewSamples()
{
  return this->AgreeOn(this->Attempt(
    [&] { return this->Files.RemoveAll(OverviewSource::GetPath(this->GetFolder(), this->Rank)); }));
}

Status BlockedVolumeWriteJob::Commit()
{
  return this->AgreeOn(this->Attempt(
    [&]() -> Status
    {
      if (this->Rank != 0)
      {
        return Status::Ok();
      }
      const std::string& folder = this->GetStep().Folder;
      for (std::size_t overview = 0; overview < this->Header.Overviews.size(); ++overview)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(
          GetStoresFolder(this->Path) + "/" + GetOverviewFolder(folder, overview)));
      }
      ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(this->GetFolder()));
      if (!this->Settings.Publish)
      {
        return Status::Ok();
      }
      ISOSURFACE_RETURN_IF_ERROR(
        GenerationFolder::Commit(this->Files, this->Path, this->Header, this->IsVisible));
      GenerationFolder::RemoveOlder(this->Files, this->Path, folder, this->Header);
      return Status::Ok();
    }));
}

} // namespace isosurface
