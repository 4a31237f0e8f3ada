// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockRounds.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/ReadingStop.h"

#include <algorithm>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

/// Rounds with more bytes of records than this and more than a layer of blocks are not faster.
constexpr std::uint64_t EnoughRecordBytes = std::uint64_t{ 32 } << 20;
/// With fewer blocks for each thread in a round, threads would wait for the last one.
constexpr std::int64_t BlocksOfThread = 16;

/// Runs a step. A shortage of memory or threads is an error like others.
template <typename Step>
Status Attempt(Step&& step)
{
  return isosurface::Attempt("a round of blocks cannot be worked on", step);
}

/// The maximum of the bytes of a block's record.
std::uint64_t FindLargestRecord(const BlockGrid& grid, const std::vector<ValueType>& types)
{
  // A block in the middle has all ghost layers. Of two blocks on an axis, the first is the larger.
  Index3 middle = grid.GetNumberOfBlocksPerAxis();
  for (std::int64_t& coordinate : middle)
  {
    coordinate = (coordinate - 1) / 2;
  }
  const std::uint64_t size = BlockRecordLayout(grid, grid.GetBlockIndex(middle), types).Size;
  return std::max(size, BlockRecordLayout(grid, 0, types).Size);
}

} // namespace

RoundPlan::RoundPlan(const BlockGrid& grid, std::size_t ranks, std::int64_t begin)
  : Ranks(ranks)
  , Row(grid.GetNumberOfBlocksPerAxis()[0])
  , Layer(Row * grid.GetNumberOfBlocksPerAxis()[1])
  , Blocks(grid.GetNumberOfBlocks())
  , Next(begin)
{
}

BlockSpan RoundPlan::CutSpan(std::int64_t begin, std::int64_t blocks) const
{
  std::int64_t count = blocks;
  if (begin % this->Layer == 0 && blocks >= this->Layer)
  {
    count = blocks / this->Layer * this->Layer;
  }
  else
  {
    const bool isRows = begin % this->Row == 0 && blocks >= this->Row;
    const std::int64_t unit = isRows ? this->Layer : this->Row;
    count = isRows ? blocks / this->Row * this->Row : blocks;
    count = std::min(count, unit - begin % unit);
  }
  return { begin, std::min(this->Blocks, begin + count) };
}

std::vector<BlockSpan> RoundPlan::Propose(std::int64_t blocks) const
{
  // The remaining blocks are divided evenly.
  const auto ranks = static_cast<std::int64_t>(this->Ranks);
  const std::int64_t remaining = this->Blocks - this->Next;
  const std::int64_t share = std::max<std::int64_t>(1, (remaining + ranks - 1) / ranks);
  std::vector<BlockSpan> spans;
  std::int64_t begin = this->Next;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    spans.push_back(this->CutSpan(begin, std::min(blocks, share)));
    begin = spans.back().End;
  }
  return spans;
}

void RoundPlan::Take(const std::vector<BlockSpan>& spans)
{
  this->Next = spans.back().End;
}

RoundWriting::RoundWriting(std::vector<PendingBlock> blocks, Write write, RecordBuffers& records,
  std::shared_ptr<RoundWriting> before)
  : Blocks(std::move(blocks))
  , WriteBlock(std::move(write))
  , Records(records)
  , Finished(Blocks.size(), false)
  , Outcome(std::async(std::launch::async,
      [this, before = std::move(before)]() mutable
      {
        const std::shared_ptr<RoundWriting> held = std::move(before);
        return this->WriteAll(held.get());
      }))
{
}

RoundWriting::~RoundWriting()
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->IsStopped = true;
  }
  this->Changed.notify_all();
  this->Outcome.wait();
}

void RoundWriting::MarkFinished(std::size_t index)
{
  bool isWanted = false;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Finished[index] = true;
    isWanted = index == this->Wanted;
  }
  if (isWanted)
  {
    this->Changed.notify_all();
  }
}

/// Waits until a block is finished. Returns false if there is nothing to wait for any longer.
bool RoundWriting::WaitFor(std::size_t index)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  this->Wanted = index;
  this->Changed.wait(lock, [&] { return this->IsStopped || this->Finished[index]; });
  return !this->IsStopped;
}

Status RoundWriting::WriteAll(RoundWriting* before)
{
  const auto write = [&]() -> Status
  {
    if (before)
    {
      ISOSURFACE_RETURN_IF_ERROR(before->Wait());
    }
    for (std::size_t index = 0; index < this->Blocks.size(); ++index)
    {
      if (!this->WaitFor(index))
      {
        return Status(StatusCode::Aborted, "writing was given up");
      }
      PendingBlock& block = this->Blocks[index];
      ISOSURFACE_RETURN_IF_ERROR(this->WriteBlock(block));
      this->Records.Return(std::move(block.Record));
    }
    return Status::Ok();
  };
  return Attempt("a round of blocks cannot be written", write);
}

BlockRounds::BlockRounds(Communicator& ranks, BoxSource& source, const BlockGrid& grid,
  const std::vector<ValueType>& types, const BlockExchange& exchange, const BlockShipment& shipment,
  RoundPlan& plan, int threads, std::uint64_t memoryBytes)
  : Ranks(ranks)
  , Source(source)
  , Grid(grid)
  , Types(types)
  , Exchange(exchange)
  , Shipment(shipment)
  , Plan(plan)
  , Threads(threads)
  , Rank(static_cast<std::size_t>(ranks.GetRank()))
  , MemoryBytes(memoryBytes)
  , RecordBytes(FindLargestRecord(grid, types))
  , Records(static_cast<std::size_t>(BlockRecord::AlignUp(RecordBytes)))
{
  this->BlocksAtOnce = this->ChooseBlocksAtOnce();
}

std::int64_t BlockRounds::ChooseBlocksAtOnce() const
{
  const Index3& blocks = this->Grid.GetNumberOfBlocksPerAxis();
  const std::uint64_t layer = static_cast<std::uint64_t>(blocks[0] * blocks[1]) * this->RecordBytes;
  const std::uint64_t enough = std::min(this->MemoryBytes / 4, std::max(layer, EnoughRecordBytes));
  const auto most = static_cast<std::int64_t>(enough / this->RecordBytes);
  // A row of blocks at once, and its samples stay in the processor's cache. Several ranks would wait
  // for each other in each round.
  const std::int64_t few = std::max<std::int64_t>(blocks[0], BlocksOfThread * this->Threads);
  const bool isByRows = this->Source.HasCheapRows() && this->Ranks.GetSize() == 1;
  return std::max<std::int64_t>(1, isByRows ? std::min(few, most) : most);
}

void BlockRounds::PrefetchLayer(const BlockSpan& span) const
{
  const Index3& blocks = this->Grid.GetNumberOfBlocksPerAxis();
  const std::int64_t layer = blocks[0] * blocks[1];
  if (span.Begin % layer == 0 && span.GetCount() < layer)
  {
    VertexBox box = this->Source.GetBox();
    box.Low[2] = this->Grid.GetVertices(span.Begin).Low[2];
    box.High[2] = std::min(box.High[2], box.Low[2] + 2 * this->Grid.GetBlockSize());
    this->Source.Prefetch(box);
  }
}

std::vector<VertexBox> BlockRounds::FindBoxes(
  const std::vector<BlockSpan>& spans, std::size_t rank) const
{
  return rank == this->Rank ? SpanSamples::FindBoxes(this->Grid, spans[rank], this->Source.GetBox())
                            : this->Exchange.FindBoxes(spans[rank], rank);
}

std::uint64_t BlockRounds::GetLoad(const std::vector<BlockSpan>& spans) const
{
  std::uint64_t samples = 0;
  std::uint64_t messages = 0;
  for (std::size_t rank = 0; rank < spans.size(); ++rank)
  {
    samples += SpanSamples::GetReadBytes(this->Source, this->FindBoxes(spans, rank));
    messages += rank == this->Rank ? 0 : this->Exchange.GetMessageBytes(spans[rank], rank);
  }
  const std::uint64_t record = PendingBlock::GetBytes(this->RecordBytes);
  const auto made = static_cast<std::uint64_t>(spans[this->Rank].GetCount());
  if (this->Exchange.IsNeeded())
  {
    messages += made * record; // received: at most all samples
  }
  const BlockShipment::Load load = this->Shipment.GetLoad(spans);
  // The samples of two rounds, since the next are read meanwhile. The blocks as made, in messages
  // and as received, and those of the round before, which are being written.
  return 2 * samples + messages +
    record * (made + load.Sent + 2 * load.Received + (load.Received + load.Kept));
}

Status BlockRounds::PlanRound(const BlockRoundsSteps& steps, std::vector<BlockSpan>& spans)
{
  for (;; this->BlocksAtOnce /= 2)
  {
    std::uint64_t load = 0;
    ISOSURFACE_RETURN_IF_ERROR(steps.Agree(Attempt(
      [&]
      {
        spans = this->Plan.Propose(this->BlocksAtOnce);
        load = this->GetLoad(spans);
        return Status::Ok();
      })));
    const std::uint64_t largest = this->Ranks.Maximum(load);
    if (largest <= this->MemoryBytes)
    {
      this->Plan.Take(spans);
      this->LargestBytes = std::max(this->LargestBytes, largest);
      ++this->Rounds;
      return Status::Ok();
    }
    if (this->BlocksAtOnce == 1)
    {
      return Status(StatusCode::InvalidArgument,
        "the memory limit is too small: a single block a rank needs " + std::to_string(largest) +
          " bytes where " + std::to_string(this->MemoryBytes) + " are left");
    }
  }
}

Status BlockRounds::StartRound(const BlockRoundsSteps& steps, Round& round)
{
  ISOSURFACE_RETURN_IF_ERROR(this->PlanRound(steps, round.Spans));
  const auto read = [this, &steps, spans = round.Spans, token = ReadingStop::Share()]
  {
    const ReadingStop stop(token);
    RoundSamples samples;
    samples.OfRank.resize(spans.size());
    samples.Outcome = Attempt(
      [&]
      {
        for (std::size_t rank = 0; rank < spans.size(); ++rank)
        {
          ISOSURFACE_RETURN_IF_ERROR(samples.OfRank[rank].Read(
            this->Source, this->FindBoxes(spans, rank), this->Types, steps.WhenRead));
        }
        return Status::Ok();
      });
    return samples;
  };
  return steps.Agree(Attempt(
    [&]
    {
      this->PrefetchLayer(round.Spans[this->Rank]);
      round.Reading =
        std::async(this->Source.CanReadAhead() ? std::launch::async : std::launch::deferred, read);
      return Status::Ok();
    }));
}

std::vector<PendingBlock> BlockRounds::MakeBlocks(const BlockSpan& span) const
{
  std::vector<PendingBlock> blocks;
  blocks.reserve(static_cast<std::size_t>(span.GetCount()));
  for (std::int64_t block = span.Begin; block < span.End; ++block)
  {
    blocks.emplace_back(this->Grid, block, this->Shipment.FindStore(block), this->Types);
  }
  return blocks;
}

Status BlockRounds::MakeRecords(const std::vector<BlockSpan>& spans, RoundSamples samples,
  const BlockRoundsSteps& steps, std::vector<PendingBlock>& blocks,
  const std::function<void(std::size_t)>& whenFinished)
{
  std::vector<Message> messages;
  if (this->Exchange.IsNeeded())
  {
    messages.resize(spans.size());
    ISOSURFACE_RETURN_IF_ERROR(steps.Agree(Attempt(
      [&]
      {
        ParallelFor(spans.size(), this->Threads,
          [&](std::size_t rank, int)
          { messages[rank] = this->Exchange.Pack(spans[rank], rank, samples.OfRank[rank]); });
        return Status::Ok();
      })));
    messages = this->Ranks.Exchange(std::move(messages));
  }
  return steps.Agree(Attempt(
    [&]
    {
      // Blocks that stay here are finished at once, others by the rank that writes them.
      return this->Exchange.Fill(blocks, samples.OfRank[this->Rank], messages, this->Records,
        [&](std::size_t index, int thread)
        {
          PendingBlock& block = blocks[index];
          if (this->Shipment.FindWriter(block.Block) == this->Rank)
          {
            const VertexBox own = this->Grid.GetVertices(block.Block);
            steps.Finish(block, samples.OfRank[this->Rank].FindViews(own), thread);
            block.IsFinished = true;
            whenFinished(index);
          }
        });
    }));
}

Status BlockRounds::Ship(const BlockRoundsSteps& steps, std::vector<PendingBlock>& blocks)
{
  std::vector<Message> messages;
  ISOSURFACE_RETURN_IF_ERROR(steps.Agree(Attempt(
    [&]
    {
      messages = this->Shipment.Pack(blocks, this->Records);
      return Status::Ok();
    })));
  messages = this->Ranks.Exchange(std::move(messages));
  return steps.Agree(
    Attempt([&] { return this->Shipment.Unpack(messages, blocks, this->Records); }));
}

std::shared_ptr<RoundWriting> BlockRounds::StartWriting(const BlockRoundsSteps& steps,
  std::vector<PendingBlock> blocks, const std::shared_ptr<RoundWriting>& before)
{
  return std::make_shared<RoundWriting>(std::move(blocks), steps.Write, this->Records, before);
}

Status BlockRounds::WorkAlone(const BlockRoundsSteps& steps, Round round, RoundSamples samples,
  std::shared_ptr<RoundWriting>& writing)
{
  const std::shared_ptr<RoundWriting> before = std::exchange(writing, nullptr);
  ISOSURFACE_RETURN_IF_ERROR(Attempt(
    [&]
    {
      writing = this->StartWriting(steps, this->MakeBlocks(round.Spans[this->Rank]), before);
      return Status::Ok();
    }));
  ISOSURFACE_RETURN_IF_ERROR(this->MakeRecords(round.Spans, std::move(samples), steps,
    writing->GetBlocks(), [&](std::size_t index) { writing->MarkFinished(index); }));
  return before ? before->Wait() : Status::Ok();
}

Status BlockRounds::WorkOnRound(const BlockRoundsSteps& steps, Round round, RoundSamples samples,
  std::shared_ptr<RoundWriting>& writing)
{
  std::vector<PendingBlock> blocks;
  ISOSURFACE_RETURN_IF_ERROR(steps.Agree(Attempt(
    [&]
    {
      blocks = this->MakeBlocks(round.Spans[this->Rank]);
      return Status::Ok();
    })));
  ISOSURFACE_RETURN_IF_ERROR(
    this->MakeRecords(round.Spans, std::move(samples), steps, blocks, [](std::size_t) {}));
  ISOSURFACE_RETURN_IF_ERROR(this->Ship(steps, blocks));
  return steps.Agree(Attempt(
    [&]
    {
      const std::shared_ptr<RoundWriting> before = std::exchange(writing, nullptr);
      writing = this->StartWriting(steps, std::move(blocks), before);
      std::vector<PendingBlock>& mine = writing->GetBlocks();
      ParallelFor(mine.size(), this->Threads,
        [&](std::size_t index, int thread)
        {
          if (!mine[index].IsFinished)
          {
            steps.Finish(mine[index], {}, thread);
          }
          writing->MarkFinished(index);
        });
      return before ? before->Wait() : Status::Ok();
    }));
}

Status BlockRounds::Run(const BlockRoundsSteps& steps)
{
  const auto blocks = static_cast<double>(this->Grid.GetNumberOfBlocks());
  if (this->Plan.IsDone())
  {
    return Status::Ok(); // an earlier write has done all
  }
  std::shared_ptr<RoundWriting> writing; // of the last round
  Round next;
  ISOSURFACE_RETURN_IF_ERROR(this->StartRound(steps, next));
  for (bool isLast = false; !isLast;)
  {
    Round round = std::exchange(next, {});
    const std::int64_t finished = this->Plan.GetCount();
    RoundSamples samples;
    ISOSURFACE_RETURN_IF_ERROR(steps.Agree(Attempt(
      [&]
      {
        ReadingStop::WaitFor(round.Reading);
        samples = round.Reading.get();
        return samples.Outcome;
      })));
    isLast = this->Plan.IsDone();
    if (!isLast)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->StartRound(steps, next));
    }
    ISOSURFACE_RETURN_IF_ERROR(round.Spans.size() > 1
        ? this->WorkOnRound(steps, std::move(round), std::move(samples), writing)
        : this->WorkAlone(steps, std::move(round), std::move(samples), writing));
    const bool goesOn = !steps.Tell || steps.Tell(static_cast<double>(finished) / blocks);
    const Status going =
      steps.Agree(goesOn ? Status::Ok() : Status(StatusCode::Aborted, "writing was aborted"));
    ISOSURFACE_RETURN_IF_ERROR(
      steps.AfterRound(finished, !going.IsOk(), [&] { return writing->Wait(); }));
    ISOSURFACE_RETURN_IF_ERROR(going);
  }
  return steps.Agree(Attempt([&] { return writing->Wait(); }));
}

} // namespace isosurface
