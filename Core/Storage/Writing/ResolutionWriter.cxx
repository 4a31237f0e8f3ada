// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/ResolutionWriter.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Distribution/BlockBalancer.h"
#include "Storage/Distribution/BlockDistribution.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/RecordCodec.h"
#include "Storage/Store/SpectraFile.h"
#include "Storage/Store/VolumeSpectra.h"
#include "Storage/Writing/BlockRounds.h"
#include "Storage/Writing/BlockShipment.h"
#include "Storage/Writing/StoreReplication.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// The shares of the work that are done when ranges are known, and when blocks are written.
constexpr double RangesDone = 0.25;
constexpr double BlocksDone = 0.98;

/// More memory does not make sorting a store's intervals faster.
constexpr std::uint64_t MaximumTreeBytes = std::uint64_t{ 64 } << 20;

} // namespace

ResolutionWriter::ResolutionWriter(const WriteContext& context, SlabSource& source,
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
  return GetStoresFolder(this->Context.Path) + "/" + this->Header.TimeSteps.back().Folder;
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
  this->Plan.emplace(this->Grid, this->Context.Size);
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
  const std::size_t segments =
    this->Types.size() * static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  bytes += mine * BlockStoreWriter::GetEntryBytes(segments);
  if (this->Spectra)
  {
    bytes += this->Spectra->GetBytes();
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
    const auto left = this->GetMemoryLeft(this->GetTableBytes());
    ISOSURFACE_RETURN_IF_ERROR(left.GetStatus());
    if (this->Header.Distribution == DistributionMethod::Balanced)
    {
      scan.AddProfiles();
    }
    return scan.Scan(this->Source, this->Exchange->GetOwned(), *left,
      [&](double share) { return this->TellShare(share * RangesDone); });
  };
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(read)));
  scan.Reduce(this->Context.Ranks);
  return Status::Ok();
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

Status ResolutionWriter::CreateStores()
{
  this->Writers.resize(this->Header.NumberOfStores);
  const std::size_t segments =
    this->Types.size() * static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  std::vector<std::size_t> blocks(this->Header.NumberOfStores, 0);
  for (const std::uint32_t store : this->BlockStores)
  {
    ++blocks[store];
  }
  for (std::uint32_t store = 0; store < this->Header.NumberOfStores; ++store)
  {
    if (!this->Context.IsMine(store))
    {
      continue;
    }
    auto writer = BlockStoreWriter::Create(this->Context.Files,
      GetStoreFolder(this->Context.Path, this->GetStep().Folder, store), segments, blocks[store],
      this->Header.IsInPlace() ? SamplePlace::Source : SamplePlace::Store);
    ISOSURFACE_RETURN_IF_ERROR(writer.GetStatus());
    this->Writers[store] = std::move(*writer);
  }
  // A rank without stores has no blocks, and no folder to write to.
  if (this->HasCoarser && this->Context.Rank < this->Header.NumberOfStores)
  {
    auto samples = this->Context.Files.CreateForWriting(
      OverviewSource::GetPath(this->GetFolder(), this->Context.Rank));
    ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
    this->OverviewSamples = std::move(*samples);
  }
  return Status::Ok();
}

Status ResolutionWriter::Write()
{
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      this->Spectra.emplace(
        MeasuredGrid{ this->Header.Grid, this->Header.Lines ? &*this->Header.Lines : nullptr },
        this->Variables, this->Header.NumberOfStores, this->Context.Rank, this->Context.Size);
      this->Ranges.assign(this->Variables.GetCount(),
        std::vector<KeyRange>(static_cast<std::size_t>(this->Grid.GetNumberOfBlocks())));
      return this->CreateStores();
    })));
  ISOSURFACE_RETURN_IF_ERROR(this->WriteBlocks());
  ISOSURFACE_RETURN_IF_ERROR(
    this->Context.AgreeOn(this->Context.Attempt([&] { return this->FinishStores(); })));
  this->ShareDescriptions();
  return this->ShareSpectra();
}

Status ResolutionWriter::WriteBlocks()
{
  const auto left = this->GetMemoryLeft(this->GetTableBytes() + this->GetThreadBytes());
  std::vector<Counters> counters;
  std::optional<BlockShipment> shipment;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      counters.reserve(static_cast<std::size_t>(this->Context.Settings.Threads));
      for (int thread = 0; thread < this->Context.Settings.Threads; ++thread)
      {
        counters.push_back(this->MakeCounters());
      }
      shipment.emplace(
        this->Grid, this->Types, this->BlockStores, this->Context.Rank, this->Context.Size);
      return left.GetStatus();
    })));
  // All ranks plan the same rounds, so the minimum counts.
  std::vector<std::uint64_t> memory = { *left };
  this->Context.Ranks.ReduceMinimum(memory);
  BlockRounds rounds(this->Context.Ranks, this->Source, this->Grid, this->Types, *this->Exchange,
    *shipment, *this->Plan, this->Context.Settings.Threads, memory[0]);
  BlockRoundsSteps steps;
  steps.Agree = [&](const Status& mine) { return this->Context.AgreeOn(mine); };
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
  const double begin = this->NeedsRanges() ? RangesDone : 0;
  steps.Tell = [&](double share) { return this->TellShare(begin + (BlocksDone - begin) * share); };
  const Status status = rounds.Run(steps);
  this->Statistics.Rounds = rounds.GetRounds();
  this->Statistics.MemoryBytes =
    this->Context.Settings.MemoryLimit - memory[0] + rounds.GetLargestBytes();
  if (status.IsOk())
  {
    this->ShareRanges(counters);
    return status;
  }
  return status.GetCode() == StatusCode::Aborted
    ? status
    : Status(status.GetCode(), this->Context.Path + ": cannot be written: " + status.GetMessage());
}

ResolutionWriter::Counters ResolutionWriter::MakeCounters() const
{
  return { BlockSpectrum(this->Spectra->GetGrid()),
    std::vector<KeyRange>(this->Variables.GetCount()) };
}

/// Joins the ranges of the finite values of all ranks, which decide the bins of all spectra.
void ResolutionWriter::ShareRanges(const std::vector<Counters>& counters)
{
  std::vector<KeyRange> finite(this->Variables.GetCount());
  CommonRanges common;
  for (std::size_t variable = 0; variable < finite.size(); ++variable)
  {
    for (const Counters& ofThread : counters)
    {
      finite[variable].Add(ofThread.FiniteRanges[variable]);
    }
    common.Add(finite[variable]);
  }
  common.Join(this->Context.Ranks);
  if (this->GetStep().Ranges.empty())
  {
    this->GetStep().Ranges = std::move(finite);
  }
}

/// Adds a filled block to the ranges and spectra, then encodes its record.
void ResolutionWriter::FinishBlock(
  PendingBlock& block, const std::vector<SampleView>& views, Counters& counters)
{
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    if (variable < views.size())
    {
      this->CountVariable(block, variable, views[variable], counters);
    }
    else
    {
      this->CountVariable(block, variable, this->AssembleVariable(block, variable)->View, counters);
    }
  }
  if (this->OverviewSamples)
  {
    block.OverviewSamples = PickOverviewSamples(this->Grid, this->Types, block);
  }
  // Samples in place have the checksums of uncompressed ones.
  EncodeRecord(this->Header.IsInPlace() ? BlockCompression() : this->Header.Compression, this->Grid,
    block.Block, this->Types, block.Layout, block.Record);
}

void ResolutionWriter::CountVariable(
  const PendingBlock& block, std::size_t variable, const SampleView& samples, Counters& counters)
{
  const SampleRange range = FindSampleRange(samples, samples.Box);
  this->Ranges[variable][static_cast<std::size_t>(block.Block)] = range.All;
  counters.FiniteRanges[variable].Add(range.Finite);
  this->Spectra->Add(block.Store, variable, counters.Spectrum.Count(samples, range));
}

/// The samples of a filled block at full resolution.
std::shared_ptr<DecodedBlock> ResolutionWriter::AssembleVariable(
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

Status ResolutionWriter::FinishStores()
{
  this->Spectra->SetRanges(this->GetStep().Ranges);
  this->GetStep().Stores.resize(this->Header.NumberOfStores);
  std::vector<std::uint32_t> mine;
  for (std::uint32_t store = 0; store < this->Header.NumberOfStores; ++store)
  {
    if (this->Writers[store])
    {
      mine.push_back(store);
    }
  }
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
      std::unique_ptr<BlockStoreWriter>& writer = this->Writers[mine[index]];
      this->Spectra->FinishStore(mine[index], writer->GetEntries(), this->Ranges);
      const auto description = writer->Finish(this->Variables, this->Ranges, memory);
      outcomes[index] = description.GetStatus();
      if (description.IsOk())
      {
        this->GetStep().Stores[mine[index]] = *description;
      }
      writer.reset();
      if (outcomes[index].IsOk())
      {
        outcomes[index] =
          ReplicateStore(this->Context.Files, this->Context.Path, this->Header, mine[index]);
      }
    },
    [&](double share) { return this->TellShare(BlocksDone + (1 - BlocksDone) * share); });
  for (const Status& outcome : outcomes)
  {
    ISOSURFACE_RETURN_IF_ERROR(outcome);
  }
  if (this->OverviewSamples)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->OverviewSamples->SyncAndClose());
    this->OverviewSamples.reset();
  }
  return isDone ? Status::Ok() : this->Context.MakeAborted();
}

void ResolutionWriter::ShareDescriptions()
{
  // A store is described by its writer, by zeros elsewhere.
  std::vector<std::uint64_t> values;
  for (const StoreDescription& store : this->GetStep().Stores)
  {
    values.insert(values.end(), { store.Blocks, store.Bytes, store.Checksum });
  }
  this->Context.Ranks.ReduceSum(values);
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
Status ResolutionWriter::ShareSpectra()
{
  std::vector<Message> outgoing(this->Context.Size);
  std::vector<WorkloadSpectrum> totals;
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      outgoing[0] = this->Spectra->Pack();
      totals = this->Spectra->GetTotals();
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
            VolumeSpectra::GetPath(this->Context.Path, this->GetStep().Folder),
            VolumeSpectra::GetIdentity(this->GetStep()), totals, this->Spectra->Unpack(incoming));
    }));
}

std::unique_ptr<OverviewSource> ResolutionWriter::MakeOverviewSource()
{
  this->Ranges.clear();
  this->Spectra.reset();
  return std::make_unique<OverviewSource>(this->Context.Files, this->GetFolder(), this->Grid,
    this->Types, std::move(this->BlockStores), this->Context.Size);
}

Status ResolutionWriter::RemoveOverviewSamples()
{
  return this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      return this->Context.Files.RemoveAll(
        OverviewSource::GetPath(this->GetFolder(), this->Context.Rank));
    }));
}

} // namespace isosurface
