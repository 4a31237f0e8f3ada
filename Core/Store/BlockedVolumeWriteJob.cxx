// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolumeWriteJob.h"

#include "Base/ByteOrder.h"
#include "Base/Checksum.h"
#include "Base/ParallelFor.h"
#include "Partition/BlockDistribution.h"
#include "Store/BlockRecord.h"
#include "Store/BlockRounds.h"
#include "Store/BlockShipment.h"
#include "Store/GenerationFolder.h"
#include "Store/OverviewSamples.h"
#include "Store/RecordCodec.h"
#include "Store/VolumeSpectra.h"

#include <algorithm>

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

} // namespace

Status BlockedVolumeWriteJob::AgreeOn(const Status& mine)
{
  std::vector<std::uint64_t> aborted = { mine.GetCode() == StatusCode::Aborted ? 1u : 0u };
  this->Ranks.ReduceMaximum(aborted);
  const Status all = this->Ranks.Agree(mine);
  return aborted[0] != 0 ? this->MakeAborted() : all;
}

Result<WriteStatistics> BlockedVolumeWriteJob::Run(
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Prepare(grid, arrays));
  ISOSURFACE_RETURN_IF_ERROR(this->FindRanges());
  ISOSURFACE_RETURN_IF_ERROR(this->MakeGeneration());
  Status status = this->CreateStores();
  if (status.IsOk())
  {
    status = this->WriteBlocks();
  }
  if (status.IsOk())
  {
    status = this->FinishStores();
  }
  if (status.IsOk())
  {
    status = this->WriteOverviews();
  }
  if (status.IsOk())
  {
    status = this->Commit();
  }
  if (!status.IsOk())
  {
    this->Writers.clear();
    this->OverviewSamples.reset();
    // Every rank has closed its files before their folder is removed.
    static_cast<void>(this->Ranks.Agree(Status::Ok()));
    if (this->Rank == 0 && !this->IsVisible)
    {
      GenerationFolder::Discard(this->Files, this->Path, this->GetStep().Folder);
    }
    return status;
  }
  return this->Statistics;
}

Status BlockedVolumeWriteJob::RunOverview(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::string& folder,
  const std::vector<KeyRange>& ranges)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Prepare(grid, arrays));
  ISOSURFACE_RETURN_IF_ERROR(this->FindRanges());
  this->GetStep().Folder = folder;
  this->GetStep().Ranges = ranges;
  ISOSURFACE_RETURN_IF_ERROR(this->CreateStores());
  ISOSURFACE_RETURN_IF_ERROR(this->WriteBlocks());
  return this->FinishStores();
}

Status BlockedVolumeWriteJob::Prepare(
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays)
{
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
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(status));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckEqualArguments());
  // A volume of several blocks has an overview, and one of a single block all levels.
  this->Grid = this->Header.GetBlockGrid();
  if (this->Grid.GetNumberOfBlocks() > 1)
  {
    this->Header.NumberOfLevels = LevelsBelowOverview;
    this->Grid = this->Header.GetBlockGrid();
  }
  for (const ArrayDescription& array : arrays)
  {
    this->Types.push_back(array.Type);
  }
  this->Header.TimeSteps.resize(1);
  this->GetStep().Time = this->Settings.Time;
  return this->ShareBoxes();
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
  // The header has all that matters; a time step stands for the rest.
  BlockedVolumeHeader header = this->Header;
  header.TimeSteps.resize(1);
  header.TimeSteps[0].Time = this->Settings.Time;
  const std::string text =
    this->Path + "\n" + header.Format() + "\n" + std::to_string(this->Settings.MemoryLimit);
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
  std::uint64_t bytes =
    blocks * (this->Types.size() * sizeof(KeyRange) + 3 * sizeof(KeyRange) + distributionBytes);
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
  // A block as it is decoded, twice that for compressing it, and what counts for the spectra.
  const std::uint64_t bytes = side * side * side * 24 +
    StoreSpectra::GetCounterBytes(
      this->Types.size(), static_cast<std::uint64_t>(this->Settings.BlockSize));
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
      this->Scan.emplace(this->Grid, this->Types, this->Settings.Threads);
      return this->Scan->Scan(this->Source, this->Exchange->GetOwned(), *left,
        [&](double share) { return this->TellShare(share * RangesDone); });
    })));
  this->Scan->Reduce(this->Ranks);
  this->GetStep().Ranges = this->Scan->GetFiniteRanges();
  return this->AgreeOn(this->Attempt(
    [&]
    {
      this->BlockStores = DistributeBlocks(this->Settings.Distribution, this->Types[0],
        this->Scan->GetRanges()[0], this->Settings.NumberOfStores, this->Settings.RandomSeed);
      return Status::Ok();
    }));
}

Status BlockedVolumeWriteJob::MakeGeneration()
{
  Status status;
  Message name;
  if (this->Rank == 0)
  {
    const auto created = GenerationFolder::Create(this->Files, this->Path);
    status = created.GetStatus();
    if (created.IsOk())
    {
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
      for (std::size_t array = 0; array < this->Types.size(); ++array)
      {
        bins.push_back(SpectrumBins::Choose(this->Types[array], this->GetStep().Ranges[array]));
      }
      this->Spectra.emplace(this->Header.Grid, this->Types, std::move(bins),
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
      if (this->Grid.GetNumberOfBlocks() > 1 && this->Rank < this->Settings.NumberOfStores)
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
  steps.Finish = [&](PendingBlock& block, int thread)
  { this->FinishBlock(block, counters[static_cast<std::size_t>(thread)]); };
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
void BlockedVolumeWriteJob::FinishBlock(PendingBlock& block, std::vector<BlockCounters>& counters)
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  for (std::size_t array = 0; array < this->Types.size(); ++array)
  {
    std::vector<const std::uint8_t*> samples;
    for (std::size_t index = array * levels; index < (array + 1) * levels; ++index)
    {
      samples.push_back(
        block.Record.GetData() + block.Layout.Offsets[index] + BlockRecord::SegmentHeaderSize);
    }
    const KeyRange& range = this->Scan->GetRanges()[array][static_cast<std::size_t>(block.Block)];
    if (range.Minimum < range.Maximum)
    {
      const auto decoded = AssembleLevel(this->Grid, block.Block, 0, this->Types[array], samples);
      counters[array].Workload.Count(decoded->View);
      counters[array].Measure.Count(decoded->View);
    }
    else
    {
      counters[array].Measure.CountUniform(
        this->Types[array], range.Minimum, this->Grid.GetVertices(block.Block));
    }
    this->Spectra->Add(block.Store, array, counters[array]);
  }
  if (this->OverviewSamples)
  {
    block.OverviewSamples = PickOverviewSamples(this->Grid, this->Types, block);
  }
  EncodeRecord(
    this->Settings.Compression, this->Grid, block.Block, this->Types, block.Layout, block.Record);
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
          const auto description = writer->Finish(this->Scan->GetRanges(), memory);
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
  Status status;
  while (status.IsOk() && (coarsest ? *coarsest : *this).Grid.GetNumberOfBlocks() > 1)
  {
    status = this->WriteOverview(coarsest);
  }
  return status;
}

/// `coarsest`: the last overview's job, null for none; then that of the one written.
Status BlockedVolumeWriteJob::WriteOverview(std::unique_ptr<BlockedVolumeWriteJob>& coarsest)
{
  BlockedVolumeWriteJob& finer = coarsest ? *coarsest : *this;
  std::optional<OverviewSource> source;
  std::unique_ptr<BlockedVolumeWriteJob> job;
  const GridGeometry grid = finer.Header.Grid.Coarsen(finer.Grid.GetNumberOfLevels());
  const std::string folder =
    GetOverviewFolder(this->GetStep().Folder, this->Header.Overviews.size());
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Attempt(
    [&]
    {
      finer.Scan.reset();
      finer.Spectra.reset();
      source.emplace(this->Files, finer.GetFolder(), finer.Grid, this->Types,
        std::move(finer.BlockStores), this->Size);
      BlockedVolumeSettings settings = this->Settings;
      const std::int64_t blocks =
        BlockGrid(grid.GetDimensions(), settings.BlockSize).GetNumberOfBlocks();
      settings.NumberOfStores = std::min(settings.NumberOfStores,
        static_cast<std::uint32_t>((blocks - 1) / BlocksPerOverviewStore + 1));
      job = std::make_unique<BlockedVolumeWriteJob>(this->Ranks, this->Files, this->Path, *source,
        settings,
        [&](double share) { return this->TellShare(StoresDone + (1 - StoresDone) * share); });
      return Status::Ok();
    })));
  ISOSURFACE_RETURN_IF_ERROR(
    job->RunOverview(grid, this->Header.Arrays, folder, this->GetStep().Ranges));
  ISOSURFACE_RETURN_IF_ERROR(finer.RemoveOverviewSamples());
  this->Header.Overviews.push_back({ job->Grid.GetNumberOfLevels(), job->Settings.NumberOfStores });
  this->GetStep().Overviews.push_back(job->GetStep().Stores);
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
      ISOSURFACE_RETURN_IF_ERROR(
        GenerationFolder::Commit(this->Files, this->Path, this->Header, this->IsVisible));
      GenerationFolder::RemoveOlder(this->Files, this->Path, folder, this->Header);
      return Status::Ok();
    }));
}

} // namespace isosurface
