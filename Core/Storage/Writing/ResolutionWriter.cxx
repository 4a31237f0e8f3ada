// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/ResolutionWriter.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Distribution/BlockBalancer.h"
#include "Storage/Distribution/BlockDistribution.h"
#include "Storage/Record/RecordCodec.h"
#include "Storage/Store/FinishedBlocks.h"
#include "Storage/Store/SpectraFile.h"
#include "Storage/Writing/BlockShipment.h"
#include "Storage/Writing/BlockStoreWriter.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

/// The shares of the work that are done when ranges are known, and when blocks are written.
constexpr double RangesDone = 0.25;
constexpr double BlocksDone = 0.98;

/// More memory does not make sorting a store's intervals faster.
constexpr std::uint64_t MaximumTreeBytes = std::uint64_t{ 64 } << 20;

/// So many blocks are told at once: after a journal was taken, all of an earlier write are told.
constexpr std::int64_t BlocksToTell = std::int64_t{ 1 } << 16;

/// The share of the time so far that passes between two checkpoints, if that is more than the
/// settings want: so they take the less of a long write.
constexpr double CheckpointShare = 0.1;

} // namespace

ResolutionWriter::ResolutionWriter(const WriteContext& context, BoxSource& source,
  const BlockedVolumeHeader& header, bool hasCoarser, Progress progress)
  : Context(context)
  , Source(source)
  , Tell(std::move(progress))
  , Header(header)
  , HasCoarser(hasCoarser)
  , Grid(header.GetBlockGrid())
  , Variables(header.GetVariables())
  , Types(Variables.GetStoredTypes())
{
}

std::string ResolutionWriter::GetFolder() const
{
  return GetStoresFolder(this->Context.Files, this->Context.Path) + "/" +
    this->Header.TimeSteps.back().Folder;
}

/// The boxes that the sources of the ranks have.
std::vector<VertexBox> ResolutionWriter::GatherBoxes() const
{
  Message mine;
  AppendBox(mine, this->Source.GetBox());
  std::vector<VertexBox> boxes;
  for (const Message& other : this->Context.Ranks.AllGather(mine))
  {
    ByteReader reader(other);
    boxes.push_back(ReadBox(reader));
  }
  return boxes;
}

Status ResolutionWriter::Prepare()
{
  this->Exchange.emplace(this->Grid, this->Types, this->GatherBoxes(), this->Context.Rank,
    this->Context.Settings.Threads);
  std::vector<std::uint64_t> covered = { 0 };
  for (const VertexBox& box : this->Exchange->GetOwned())
  {
    covered[0] += static_cast<std::uint64_t>(box.GetNumberOfVertices());
  }
  this->Context.Ranks.ReduceSum(covered);
  const auto all = static_cast<std::uint64_t>(this->Header.Grid.GetNumberOfVertices());
  return covered[0] == all
    ? Status::Ok()
    : this->Context.MakeRefusal("the ranks' pieces cover " + std::to_string(covered[0]) + " of " +
        std::to_string(all) + " vertices");
}

/// The bytes of tables of blocks and bins that are held during the rounds.
std::uint64_t ResolutionWriter::GetTableBytes() const
{
  const auto blocks = static_cast<std::uint64_t>(this->Grid.GetNumberOfBlocks());
  // Ranges, three more of them while they are joined; stores and the memory of distributing.
  constexpr std::uint64_t distributionBytes = 48;
  std::uint64_t bytes = blocks *
    (this->Variables.GetCount() * sizeof(KeyRange) + 3 * sizeof(KeyRange) + distributionBytes);
  if (this->Header.Distribution == DistributionMethod::Balanced && this->BlockStores.empty())
  {
    bytes +=
      BlockProfileScan::GetBytes(this->Grid) + BlockBalancer::GetBytes(this->Header.NumberOfStores);
  }
  std::uint64_t mine = 0;
  for (const std::uint32_t store : this->BlockStores)
  {
    mine += this->Context.IsMine(store) ? 1 : 0;
  }
  const std::uint64_t copies = this->TellsFinished() && !this->Header.IsInPlace() ? 2 : 1;
  bytes +=
    copies * mine * BlockStoreWriter::GetEntryBytes(WrittenStores::CountSegments(this->Header));
  if (this->Counts)
  {
    bytes += this->Counts->GetSpectra().GetBytes();
  }
  return bytes + this->Source.GetHeldBytes();
}

/// The bytes that the threads take for a block each.
std::uint64_t ResolutionWriter::GetThreadBytes() const
{
  const auto side = static_cast<std::uint64_t>(this->Header.BlockSize) + 3;
  // A decoded block and twice that to compress it, or a magnitude and its components; and the
  // counters of the spectra.
  std::uint64_t vertexBytes = 24;
  for (const ArrayDescription& array : this->Header.Arrays)
  {
    const auto components = static_cast<std::uint64_t>(array.Components);
    vertexBytes = std::max(vertexBytes, components * GetValueSize(array.Type) + sizeof(double));
  }
  const std::uint64_t bytes = side * side * side * vertexBytes +
    StoreSpectra::GetCounterBytes(static_cast<std::uint64_t>(this->Header.BlockSize));
  return static_cast<std::uint64_t>(this->Context.Settings.Threads) * bytes;
}

Result<std::uint64_t> ResolutionWriter::GetMemoryLeft(std::uint64_t taken) const
{
  // An eighth is left to what cannot be planned: the heap's overhead, stacks, files.
  const std::uint64_t usable =
    this->Context.Settings.MemoryLimit - this->Context.Settings.MemoryLimit / 8;
  if (taken >= usable)
  {
    return this->Context.MakeRefusal("the memory limit of " +
      std::to_string(this->Context.Settings.MemoryLimit) +
      " bytes is too small: tables of blocks, "
      "bins and threads alone take " +
      std::to_string(taken));
  }
  return usable - taken;
}

/// Whether what is in a block decides where it is stored.
bool ResolutionWriter::NeedsRanges() const
{
  return this->Header.NumberOfStores > 1 &&
    this->Header.Distribution != DistributionMethod::Random &&
    this->Header.Distribution != DistributionMethod::Slab;
}

Status ResolutionWriter::ScanRanges(BlockRangeScan& scan)
{
  const auto read = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto left, this->GetMemoryLeft(this->GetTableBytes()));
    if (this->Header.Distribution == DistributionMethod::Balanced)
    {
      scan.AddProfiles();
    }
    return scan.Scan(this->Source, this->Exchange->GetOwned(), left,
      [&](double share) { return this->TellShare(share * RangesDone); });
  };
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(read)));
  return scan.Reduce(this->Context.Ranks, this->Context.Path);
}

Status ResolutionWriter::Distribute()
{
  std::optional<BlockRangeScan> scan;
  if (this->NeedsRanges())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
      [&]
      {
        scan.emplace(this->Grid, this->Variables, this->Context.Settings.Threads);
        return Status::Ok();
      })));
    ISOSURFACE_RETURN_IF_ERROR(this->ScanRanges(*scan));
  }
  return this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      const std::size_t variable = *this->Variables.Find(0, Variable::Magnitude);
      const auto blocks = static_cast<std::size_t>(this->Grid.GetNumberOfBlocks());
      const std::vector<KeyRange> unknown(scan ? 0 : blocks);
      // A single store has all blocks, whatever the method.
      const bool isSingle = this->Header.NumberOfStores == 1;
      this->BlockStores =
        DistributeBlocks(isSingle ? DistributionMethod::Slab : this->Header.Distribution,
          this->Variables[variable].Type, scan ? scan->GetRanges() : unknown,
          this->Header.NumberOfStores, this->Header.RandomSeed,
          scan ? scan->TakeProfiles() : std::vector<BlockProfile>());
      return Status::Ok();
    }));
}

/// Goes on with the stores as a journal says, or creates them. Collective.
Status ResolutionWriter::OpenStores()
{
  const auto clear = [&]
  {
    this->Stores.emplace(
      this->Context, this->Header, this->BlockStores, this->HasCoarser, this->Journal != nullptr);
    this->Counts.emplace(
      this->Header, this->Context.Rank, this->Context.Size, this->Context.Settings.Threads);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(clear)));
  if (this->Journal && this->Journal->Blocks > 0)
  {
    const auto take = [&] { return this->Stores->Take(*this->Journal, *this->Counts); };
    if (this->Context.AgreeOn(this->Context.Attempt(take)).IsOk())
    {
      return Status::Ok();
    }
    // What is left of it cannot be used. It begins anew.
    this->Journal->Blocks = 0;
    ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(clear)));
  }
  return this->Context.AgreeOn(this->Context.Attempt([&] { return this->Stores->Create(); }));
}

Status ResolutionWriter::Write()
{
  this->Begin = this->LastCheckpoint = Clock::now();
  ISOSURFACE_RETURN_IF_ERROR(this->OpenStores());
  ISOSURFACE_RETURN_IF_ERROR(this->WriteBlocks());
  const Status finished =
    this->Context.AgreeOn(this->Context.Attempt([&] { return this->FinishStores(); }));
  if (finished.GetCode() == StatusCode::Corrupt && this->Journal)
  {
    this->Journal->Blocks = 0; // the next write does not go on with these files
  }
  ISOSURFACE_RETURN_IF_ERROR(finished);
  ISOSURFACE_RETURN_IF_ERROR(this->ShareDescriptions());
  return this->ShareSpectra();
}

/// Whether a checkpoint is made after a round. Collective: the first rank's clock decides.
bool ResolutionWriter::IsCheckpointDue(std::int64_t blocks, bool isStopping)
{
  if (isStopping)
  {
    return true;
  }
  const Clock::time_point now = Clock::now();
  const auto count = [&](Clock::time_point from)
  { return std::chrono::duration<double>(now - from).count(); };
  const double seconds = *this->Context.Settings.JournalSeconds;
  // The last blocks are always kept: sorting intervals and the overviews can take long.
  const bool isLast = blocks == this->Grid.GetNumberOfBlocks();
  const double wanted = isLast ? seconds : std::max(seconds, CheckpointShare * count(this->Begin));
  return this->Context.Ranks.Any(
    this->Context.Rank == 0 && count(isLast ? this->Begin : this->LastCheckpoint) >= wanted);
}

/// Brings all that is known of the first `blocks` blocks, which are written, to stable storage.
/// Collective.
Status ResolutionWriter::MakeCheckpoint(std::int64_t blocks)
{
  WriteJournal next = *this->Journal;
  next.Blocks = blocks;
  ++next.Checkpoint;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&] { return this->Stores->AddCheckpoints(next.Checkpoint, *this->Counts); })));
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      return this->Context.Rank == 0 ? next.Write(this->Context.Files, this->Context.Path)
                                     : Status::Ok();
    })));
  *this->Journal = std::move(next);
  this->LastCheckpoint = Clock::now();
  return Status::Ok();
}

Status ResolutionWriter::WriteBlocks()
{
  const auto left = this->GetMemoryLeft(this->GetTableBytes() + this->GetThreadBytes());
  std::optional<BlockShipment> shipment;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      this->Plan.emplace(this->Grid, this->Context.Size, this->Journal ? this->Journal->Blocks : 0);
      shipment.emplace(
        this->Grid, this->Types, this->BlockStores, this->Context.Rank, this->Context.Size);
      return left.GetStatus();
    })));
  // All ranks plan the same rounds, so the minimum counts.
  const std::uint64_t memory = this->Context.Ranks.Minimum(*left);
  BlockRounds rounds(this->Context.Ranks, this->Source, this->Grid, this->Types, *this->Exchange,
    *shipment, *this->Plan, this->Context.Settings.Threads, memory);
  BlockRoundsSteps steps;
  steps.Agree = [&](const Status& mine) { return this->Context.AgreeOn(mine); };
  steps.Finish = [&](PendingBlock& block, const std::vector<SampleView>& views, int thread)
  { this->FinishBlock(block, views, thread); };
  steps.Write = [&](const PendingBlock& block) { return this->Stores->Append(block); };
  steps.AfterRound = [&](std::int64_t blocks, bool isStopping,
                       const std::function<Status()>& waitUntilWritten) -> Status
  {
    const bool isDue = this->Journal && this->IsCheckpointDue(blocks, isStopping);
    const bool tellsFinished = this->TellsFinished() && !isStopping;
    if (isDue || (tellsFinished && !this->Header.IsInPlace())) // records that are told can be read
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(waitUntilWritten)));
    }
    if (isDue)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->MakeCheckpoint(blocks));
    }
    while (tellsFinished && this->ToldBlocks < blocks)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->TellBlocks(std::min(blocks, this->ToldBlocks + BlocksToTell)));
    }
    return Status::Ok();
  };
  const double begin = this->NeedsRanges() ? RangesDone : 0;
  steps.WhenRead = this->TellsCaller ? this->Context.Settings.WhenRead : nullptr;
  steps.Tell = [&](double share) { return this->TellShare(begin + (BlocksDone - begin) * share); };
  const Status status = rounds.Run(steps);
  this->Statistics.Rounds = rounds.GetRounds();
  this->Statistics.MemoryBytes =
    this->Context.Settings.MemoryLimit - memory + rounds.GetLargestBytes();
  if (status.IsOk())
  {
    this->ShareRanges();
    return status;
  }
  return status.GetCode() == StatusCode::Aborted
    ? status
    : Status(status.GetCode(), this->Context.Path + ": cannot be written: " + status.GetMessage());
}

/// Tells which of the first `blocks` blocks are finished since the last time. A rank knows the ranges
/// of those alone that it writes. Collective.
Status ResolutionWriter::TellBlocks(std::int64_t blocks)
{
  FinishedBlocks finished;
  CommonRanges common;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      for (const std::vector<KeyRange>& all : this->Counts->GetRanges())
      {
        finished.Ranges.emplace_back(all.begin() + this->ToldBlocks, all.begin() + blocks);
      }
      if (!this->Header.IsInPlace())
      {
        this->Stores->FindRecords(this->ToldBlocks, blocks, finished.Records);
      }
      for (std::vector<KeyRange>& ofVariable : finished.Ranges)
      {
        std::for_each(
          ofVariable.begin(), ofVariable.end(), [&](KeyRange& range) { common.Add(range); });
      }
      return Status::Ok();
    })));
  common.Join(this->Context.Ranks);
  this->ToldBlocks = blocks;
  return this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      this->Context.Settings.WhenFinished(this->Header, std::move(finished));
      return Status::Ok();
    }));
}

/// Joins the ranges of the finite values of all ranks, which decide the bins of all spectra.
void ResolutionWriter::ShareRanges()
{
  std::vector<KeyRange> finite = this->Counts->JoinFiniteRanges();
  CommonRanges common;
  for (KeyRange& range : finite)
  {
    common.Add(range);
  }
  common.Join(this->Context.Ranks);
  if (this->GetStep().Ranges.empty())
  {
    this->GetStep().Ranges = std::move(finite);
  }
}

/// Counts a filled block, then encodes its record.
void ResolutionWriter::FinishBlock(
  PendingBlock& block, const std::vector<SampleView>& views, int thread)
{
  this->Counts->Add(block, views, thread);
  if (this->HasCoarser)
  {
    block.OverviewSamples = PickOverviewSamples(this->Grid, this->Types, block);
  }
  // Samples in place have the checksums of uncompressed ones.
  EncodeRecord(this->Header.IsInPlace() ? BlockCompression() : this->Header.Compression, this->Grid,
    block.Block, this->Types, block.Layout, block.Record);
}

Status ResolutionWriter::FinishStores()
{
  this->Counts->GetSpectra().SetRanges(this->GetStep().Ranges);
  this->GetStep().Stores.resize(this->Header.NumberOfStores);
  const std::vector<std::uint32_t> mine = this->Stores->GetNumbers();
  // Together, so that the disk is waited for once rather than once a store.
  const auto threads = std::min<std::size_t>(std::max<std::size_t>(1, mine.size()),
    static_cast<std::size_t>(this->Context.Settings.Threads));
  const auto left = this->GetMemoryLeft(this->GetTableBytes());
  const std::size_t memory =
    static_cast<std::size_t>(left.IsOk() ? std::min(*left, MaximumTreeBytes) : 0) / threads;
  std::vector<Status> outcomes(mine.size());
  const bool isDone = ParallelFor(
    mine.size(), static_cast<int>(threads),
    [&](std::size_t index, int)
    {
      const auto description = this->Stores->Finish(mine[index], *this->Counts, memory);
      outcomes[index] = description.GetStatus();
      if (description.IsOk())
      {
        this->GetStep().Stores[mine[index]] = *description;
        outcomes[index] =
          ReplicateStore(this->Context.Files, this->Context.Path, this->Header, mine[index]);
      }
    },
    [&](double share) { return this->TellShare(BlocksDone + (1 - BlocksDone) * share); });
  for (const Status& outcome : outcomes)
  {
    ISOSURFACE_RETURN_IF_ERROR(outcome);
  }
  return isDone ? Status::Ok() : this->Context.MakeAborted();
}

Status ResolutionWriter::ShareDescriptions()
{
  // A store is described by its writer, by zeros elsewhere.
  std::vector<std::uint64_t> values;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      for (StoreDescription& store : this->GetStep().Stores)
      {
        store.Seals.resize(1 + this->Variables.GetCount());
        values.insert(values.end(), { store.Blocks, store.Bytes, store.Checksum });
        values.insert(values.end(), store.Seals.begin(), store.Seals.end());
      }
      this->Statistics.Stores = this->GetStep().Stores;
      return Status::Ok();
    })));
  this->Context.Ranks.ReduceSum(values);
  auto value = values.begin();
  for (StoreDescription& store : this->Statistics.Stores)
  {
    store.Blocks = *value++;
    store.Bytes = *value++;
    store.Checksum = *value++;
    std::copy_n(value, store.Seals.size(), store.Seals.begin());
    value += static_cast<std::ptrdiff_t>(store.Seals.size());
    this->Statistics.Blocks += store.Blocks;
    this->Statistics.Bytes += store.Bytes;
  }
  // Its lists are as long as those of the statistics.
  this->GetStep().Stores = this->Statistics.Stores;
  return Status::Ok();
}

/// Brings the spectra of all stores to rank 0, which writes them.
Status ResolutionWriter::ShareSpectra()
{
  std::vector<Message> outgoing(this->Context.Size);
  std::vector<WorkloadSpectrum> totals;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      outgoing[0] = this->Counts->GetSpectra().Pack();
      totals = this->Counts->GetSpectra().GetTotals();
      return Status::Ok();
    })));
  const std::vector<Message> incoming = this->Context.Ranks.Exchange(std::move(outgoing));
  StoreSpectra::ReduceTotals(this->Context.Ranks, totals);
  return this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      return this->Context.Rank != 0
        ? Status::Ok()
        : SpectraFile::Write(this->Context.Files,
            VolumeSpectra::GetPath(this->Context.Files, this->Context.Path, this->GetStep().Folder),
            VolumeSpectra::GetIdentity(this->GetStep()), totals,
            this->Counts->GetSpectra().Unpack(incoming));
    }));
}

std::unique_ptr<OverviewSource> ResolutionWriter::MakeOverviewSource()
{
  this->Counts.reset();
  return std::make_unique<OverviewSource>(this->Context.Files, this->GetFolder(), this->Grid,
    this->Types, std::move(this->BlockStores), this->Header.NumberOfStores);
}

Status ResolutionWriter::RemoveTemporaryFiles()
{
  return this->Context.AgreeOn(
    this->Context.Attempt([&] { return this->Stores->RemoveTemporaryFiles(); }));
}

} // namespace isosurface
