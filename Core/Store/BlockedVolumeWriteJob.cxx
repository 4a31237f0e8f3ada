// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolumeWriteJob.h"

#include "Base/ByteOrder.h"
#include "Base/Checksum.h"
#include "Base/ParallelFor.h"
#include "Partition/BlockDistribution.h"
#include "Store/BlockRecord.h"
#include "Store/GenerationFolder.h"
#include "Store/PieceOwnership.h"
#include "Store/RecordCodec.h"
#include "Store/VolumeSpectra.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// The shares of the work that are done when ranges are known, and when blocks are written.
constexpr double RangesDone = 0.15;
constexpr double BlocksDone = 0.9;

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
    status = this->Commit();
  }
  if (!status.IsOk())
  {
    this->Writers.clear();
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
    status = this->CheckPiece();
  }
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(status));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckEqualArguments());
  this->Grid = BlockGrid(grid.GetDimensions(), this->Settings.BlockSize);
  for (const ArrayDescription& array : arrays)
  {
    this->Types.push_back(array.Type);
  }
  this->Header.TimeSteps.resize(1);
  this->GetStep().Time = this->Settings.Time;
  return this->ShareBoxes();
}

Status BlockedVolumeWriteJob::CheckPiece() const
{
  if (this->Piece.Box.IsEmpty())
  {
    return Status::Ok();
  }
  const auto contains = [](const VertexBox& outer, const VertexBox& inner)
  { return outer.Intersect(inner) == inner; };
  bool fits = contains({ { 0, 0, 0 }, this->Header.Grid.GetDimensions() }, this->Piece.Box) &&
    this->Piece.Arrays.size() == this->Header.Arrays.size();
  for (std::size_t array = 0; fits && array < this->Piece.Arrays.size(); ++array)
  {
    const SampleView& view = this->Piece.Arrays[array];
    fits = view.Type == this->Header.Arrays[array].Type &&
      contains(view.Available, this->Piece.Box) && view.First;
  }
  return fits
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument,
        this->Path + ": cannot be written: a rank's piece does not fit the grid or arrays");
}

Status BlockedVolumeWriteJob::CheckEqualArguments()
{
  // The header has all that matters; a time step stands for the rest.
  BlockedVolumeHeader header = this->Header;
  header.TimeSteps.resize(1);
  header.TimeSteps[0].Time = this->Settings.Time;
  const std::string text =
    this->Path + "\n" + header.Format() + "\n" + std::to_string(this->Settings.RoundBytes);
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
  for (const Index3& corner : { this->Piece.Box.Low, this->Piece.Box.High })
  {
    mine.insert(mine.end(), corner.begin(), corner.end());
  }
  Message message(mine.size() * sizeof(std::int64_t));
  for (std::size_t index = 0; index < mine.size(); ++index)
  {
    StoreLittleEndian(message.data() + 8 * index, mine[index]);
  }
  for (const Message& other : this->Ranks.AllGather(message))
  {
    VertexBox box;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box.Low[axis] = LoadLittleEndian<std::int64_t>(other.data() + 8 * axis);
      box.High[axis] = LoadLittleEndian<std::int64_t>(other.data() + 24 + 8 * axis);
    }
    this->Boxes.push_back(box);
  }
  this->Owned = FindOwnedBoxes(this->Boxes, this->Rank);
  std::vector<std::uint64_t> covered = { 0 };
  for (const VertexBox& box : this->Owned)
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

Status BlockedVolumeWriteJob::FindRanges()
{
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Attempt(
    [&]
    {
      const bool isDone = this->Scan.Scan(this->Grid, this->Piece, this->Owned, this->Types.size(),
        this->Settings.Threads, [&](double share) { return this->TellShare(share * RangesDone); });
      return isDone ? Status::Ok() : this->MakeAborted();
    })));
  this->Scan.Reduce(this->Ranks);
  this->GetStep().Ranges = this->Scan.GetFiniteRanges();
  return this->AgreeOn(this->Attempt(
    [&]
    {
      this->BlockStores = DistributeBlocks(this->Settings.Distribution, this->Types[0],
        this->Scan.GetRanges()[0], this->Settings.NumberOfStores, this->Settings.RandomSeed);
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
      this->StoreSpectra.resize(this->Settings.NumberOfStores);
      const std::size_t segments =
        this->Types.size() * static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
      for (std::uint32_t store = 0; store < this->Settings.NumberOfStores; ++store)
      {
        if (this->GetWriter(store) != this->Rank)
        {
          continue;
        }
        auto writer = BlockStoreWriter::Create(
          this->Files, GetStoreFolder(this->Path, this->GetStep().Folder, store), segments);
        if (!writer.IsOk())
        {
          return writer.GetStatus();
        }
        this->Writers[store] = std::move(*writer);
        this->StoreSpectra[store] = std::make_unique<Spectra>();
        for (std::size_t array = 0; array < this->Types.size(); ++array)
        {
          this->StoreSpectra[store]->Arrays.emplace_back(
            SpectrumBins::Choose(this->Types[array], this->GetStep().Ranges[array]));
        }
      }
      return Status::Ok();
    }));
}

Status BlockedVolumeWriteJob::WriteBlocks()
{
  const BlockExchange exchange(this->Ranks, this->Grid, this->Types, this->Piece, this->Boxes,
    this->Owned, this->Settings.Threads);
  const std::int64_t blocks = this->Grid.GetNumberOfBlocks();
  for (std::int64_t next = 0; next < blocks;)
  {
    Round round;
    round.Begin = next;
    ISOSURFACE_RETURN_IF_ERROR(
      this->AgreeOn(this->Attempt([&] { return this->PackRound(exchange, round); })));
    const std::vector<Message> messages = this->Ranks.Exchange(std::move(round.Messages));
    Status status = this->Attempt(
      [&]() -> Status
      {
        ISOSURFACE_RETURN_IF_ERROR(exchange.Fill(round.Mine, messages));
        return this->FinishRound(round.Mine);
      });
    next = round.End;
    const double share = static_cast<double>(next) / static_cast<double>(blocks);
    if (status.IsOk() && !this->TellShare(RangesDone + (BlocksDone - RangesDone) * share))
    {
      status = this->MakeAborted();
    }
    ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(status));
    ++this->Statistics.Rounds;
    this->Statistics.LargestRoundBytes = std::max(this->Statistics.LargestRoundBytes, round.Bytes);
  }
  return Status::Ok();
}

Status BlockedVolumeWriteJob::PackRound(const BlockExchange& exchange, Round& round) const
{
  // As many blocks as the budget allows, but at least one.
  std::vector<BlockExchange::Target> targets;
  const std::int64_t blocks = this->Grid.GetNumberOfBlocks();
  for (round.End = round.Begin; round.End < blocks; ++round.End)
  {
    const std::uint64_t size = BlockRecordLayout(this->Grid, round.End, this->Types).Size;
    if (round.End > round.Begin && round.Bytes + size > this->Settings.RoundBytes)
    {
      break;
    }
    round.Bytes += size;
    const std::uint32_t store = this->BlockStores[static_cast<std::size_t>(round.End)];
    targets.push_back({ round.End, static_cast<int>(this->GetWriter(store)) });
    if (this->GetWriter(store) == this->Rank)
    {
      round.Mine.emplace_back(this->Grid, round.End, store, this->Types);
    }
  }
  round.Messages = exchange.Pack(targets);
  return Status::Ok();
}

Status BlockedVolumeWriteJob::FinishRound(std::vector<PendingBlock>& blocks)
{
  std::vector<std::vector<BlockWorkload>> counters(
    static_cast<std::size_t>(this->Settings.Threads));
  ParallelFor(blocks.size(), this->Settings.Threads,
    [&](std::size_t index, int thread)
    {
      std::vector<BlockWorkload>& mine = counters[static_cast<std::size_t>(thread)];
      for (std::size_t array = mine.size(); array < this->Types.size(); ++array)
      {
        mine.emplace_back(
          SpectrumBins::Choose(this->Types[array], this->Header.TimeSteps[0].Ranges[array]));
      }
      this->FinishBlock(blocks[index], mine);
    });
  for (const PendingBlock& block : blocks)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Writers[block.Store]->Append(block));
  }
  return Status::Ok();
}

/// Counts the triangles of a filled block, and makes its record what the file will have.
void BlockedVolumeWriteJob::FinishBlock(PendingBlock& block, std::vector<BlockWorkload>& counters)
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
    const KeyRange& range = this->Scan.GetRanges()[array][static_cast<std::size_t>(block.Block)];
    if (range.Minimum < range.Maximum)
    {
      const auto decoded = AssembleLevel(this->Grid, block.Block, 0, this->Types[array], samples);
      counters[array].Count(decoded->View);
      Spectra& spectra = *this->StoreSpectra[block.Store];
      const std::lock_guard<std::mutex> lock(spectra.Mutex);
      counters[array].MoveTo(spectra.Arrays[array]);
    }
  }
  EncodeRecord(this->Settings.Compression, this->Grid, block.Block, this->Types, block.Layout,
    block.Record);
}

Status BlockedVolumeWriteJob::FinishStores()
{
  this->GetStep().Stores.resize(this->Settings.NumberOfStores);
  const Status status = this->Attempt(
    [&]() -> Status
    {
      for (std::uint32_t store = 0; store < this->Settings.NumberOfStores; ++store)
      {
        if (!this->Writers[store])
        {
          continue;
        }
        const auto description =
          this->Writers[store]->Finish(this->Scan.GetRanges(), this->Settings.IndexBytes);
        if (!description.IsOk())
        {
          return description.GetStatus();
        }
        this->GetStep().Stores[store] = *description;
        this->Writers[store].reset();
        const double share = static_cast<double>(store + 1) / this->Settings.NumberOfStores;
        if (!this->TellShare(BlocksDone + (1 - BlocksDone) * share))
        {
          return this->MakeAborted();
        }
      }
      return Status::Ok();
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

/// Brings the spectra of all stores to rank 0, store by store, array by array.
Status BlockedVolumeWriteJob::ShareSpectra()
{
  std::vector<Message> outgoing(this->Size);
  const auto visit = [&](std::size_t rank, auto&& perCounts)
  {
    for (std::uint32_t store = 0; store < this->Settings.NumberOfStores; ++store)
    {
      for (std::size_t array = 0; array < this->Types.size(); ++array)
      {
        if (this->GetWriter(store) == rank)
        {
          perCounts(store, array);
        }
      }
    }
  };
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOn(this->Attempt(
    [&]
    {
      visit(this->Rank,
        [&](std::uint32_t store, std::size_t array)
        { VolumeSpectra::AppendCounts(this->StoreSpectra[store]->Arrays[array], outgoing[0]); });
      return Status::Ok();
    })));
  const std::vector<Message> incoming = this->Ranks.Exchange(std::move(outgoing));
  return this->AgreeOn(this->Attempt(
    [&]() -> Status
    {
      if (this->Rank != 0)
      {
        return Status::Ok();
      }
      std::vector<std::vector<WorkloadSpectrum>> spectra;
      for (std::size_t array = 0; array < this->Types.size(); ++array)
      {
        const WorkloadSpectrum empty(
          SpectrumBins::Choose(this->Types[array], this->GetStep().Ranges[array]));
        spectra.emplace_back(this->Settings.NumberOfStores, empty);
      }
      for (std::size_t rank = 0; rank < this->Size; ++rank)
      {
        std::size_t position = 0;
        visit(rank,
          [&](std::uint32_t store, std::size_t array)
          { VolumeSpectra::TakeCounts(incoming[rank], position, spectra[array][store]); });
      }
      return VolumeSpectra::Write(
        this->Files, VolumeSpectra::GetPath(this->Path, this->GetStep().Folder), spectra);
    }));
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
      ISOSURFACE_RETURN_IF_ERROR(
        this->Files.SyncDirectory(GetStoresFolder(this->Path) + "/" + folder));
      ISOSURFACE_RETURN_IF_ERROR(
        GenerationFolder::Commit(this->Files, this->Path, this->Header, this->IsVisible));
      GenerationFolder::RemoveOlder(this->Files, this->Path, folder, this->Header);
      return Status::Ok();
    }));
}

} // namespace isosurface
