// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRounds_h
#define isosurface_BlockRounds_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BoxSource.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/BlockShipment.h"
#include "Storage/Writing/RecordBuffers.h"
#include "Storage/Writing/SpanSamples.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

/// Plans which rank makes the records of which blocks in which round; equal on all ranks. A round
/// is a span of blocks, divided among the ranks. So blocks come in the order of their indices, and
/// stores are written by appending records of any size.
class RoundPlan
{
public:
  /// `begin`: the first block that is planned.
  RoundPlan(const BlockGrid& grid, std::size_t ranks, std::int64_t begin);

  bool IsDone() const { return this->Next == this->Blocks; }
  /// How many blocks are planned, with those before the first one.
  std::int64_t GetCount() const { return this->Next; }

  /// The spans of the next round, one for each rank, of at most `blocks` (> 0) blocks: whole layers
  /// of blocks, whole rows, or parts of a row, so that few samples are read twice.
  std::vector<BlockSpan> Propose(std::int64_t blocks) const;
  /// Continues after these spans.
  void Take(const std::vector<BlockSpan>& spans);

private:
  BlockSpan CutSpan(std::int64_t begin, std::int64_t blocks) const;

  std::size_t Ranks;
  std::int64_t Row;
  std::int64_t Layer;
  std::int64_t Blocks;
  std::int64_t Next;
};

/**
 * Writes the blocks of a round in their order by a thread of its own, each as soon as it and all
 * blocks before it are finished. So few records wait at a time, and their memory, which is used
 * again at once, stays in the processor's cache.
 */
class RoundWriting
{
public:
  using Write = std::function<Status(const PendingBlock&)>;

  /// Starts the thread. It waits for `before`, the writing of the round before, which may be null.
  /// The records of written blocks return to `records`, which must outlive this object, as must
  /// what `write` refers to. Throws std::system_error if there is no thread.
  RoundWriting(std::vector<PendingBlock> blocks, Write write, RecordBuffers& records,
    std::shared_ptr<RoundWriting> before);
  RoundWriting(const RoundWriting&) = delete;
  RoundWriting& operator=(const RoundWriting&) = delete;
  /// Gives up the blocks that are not written.
  ~RoundWriting();

  /// A block may be changed until it is marked as finished.
  std::vector<PendingBlock>& GetBlocks() { return this->Blocks; }
  /// Any thread may mark a block, each once.
  void MarkFinished(std::size_t index);
  /// Waits until all blocks are written; all have to be marked. Returns the first error of this
  /// round and those before it. Any number of threads may wait.
  Status Wait()
  {
    std::shared_future<Status> outcome = this->Outcome; // one for each thread
    return outcome.get();
  }

private:
  Status WriteAll(RoundWriting* before);
  bool WaitFor(std::size_t index);

  std::vector<PendingBlock> Blocks;
  Write WriteBlock;
  RecordBuffers& Records;
  std::mutex Mutex;
  std::condition_variable Changed;
  std::vector<bool> Finished; ///< per block
  std::size_t Wanted = 0;     ///< the block that the thread waits for
  bool IsStopped = false;
  std::shared_future<Status> Outcome; ///< the last member, since the thread uses the others
};

/// The steps of a round that the caller provides.
struct BlockRoundsSteps
{
  /// Makes all ranks agree, like Communicator::Agree.
  std::function<Status(const Status&)> Agree;
  /// Completes the record of a block that this rank writes; called by several threads at once. The
  /// views, one an array, are of the samples of its vertices; empty if only the record has them.
  std::function<void(PendingBlock&, const std::vector<SampleView>&, int thread)> Finish;
  /// Writes a finished block; called by one thread at a time, in the order of the blocks.
  std::function<Status(const PendingBlock&)> Write;
  /// Called by all ranks after each round: `blocks` are finished, from the first one on. It may wait
  /// until they are written. `isStopping`: whether no round follows, since the user asks to stop.
  std::function<Status(
    std::int64_t blocks, bool isStopping, const std::function<Status()>& waitUntilWritten)>
    AfterRound;
  Progress Tell;
  /// Called with what is read of the source, by the thread that reads; may be null.
  std::function<void(const BoxSamples& slab, const VertexBox& box)> WhenRead;
};

/**
 * Makes the records of all blocks from the samples of the ranks' sources, and brings them to their
 * writers, in rounds. In a round every rank reads, sends, finishes and writes its share. Meanwhile
 * the samples of the next round are read and the blocks of the last one are written.
 *
 * Memory: the samples and records of two rounds, and the messages of one. Rounds are so small that
 * all ranks keep within `memoryBytes`.
 */
class BlockRounds
{
public:
  /// The references must outlive this object. `memoryBytes` is the same on all ranks.
  BlockRounds(Communicator& ranks, BoxSource& source, const BlockGrid& grid,
    const std::vector<ValueType>& types, const BlockExchange& exchange,
    const BlockShipment& shipment, RoundPlan& plan, int threads, std::uint64_t memoryBytes);

  /// Collective. InvalidArgument if one block for each rank does not fit the memory.
  Status Run(const BlockRoundsSteps& steps);

  std::uint64_t GetRounds() const { return this->Rounds; }
  /// The maximum memory that was planned for a round on any rank.
  std::uint64_t GetLargestBytes() const { return this->LargestBytes; }

private:
  /// The samples for this rank's own span, and for its messages to each other rank.
  struct RoundSamples
  {
    Status Outcome;
    std::vector<SpanSamples> OfRank;
  };

  struct Round
  {
    std::vector<BlockSpan> Spans; ///< per rank
    std::future<RoundSamples> Reading;
  };

  /// Plans the next round, and starts reading for it.
  Status StartRound(const BlockRoundsSteps& steps, Round& round);
  std::int64_t ChooseBlocksAtOnce() const;
  /// Tells the source the boxes that are read soon, when a layer of blocks begins that is read row
  /// by row.
  void PrefetchLayer(const BlockSpan& span) const;
  Status PlanRound(const BlockRoundsSteps& steps, std::vector<BlockSpan>& spans);
  std::uint64_t GetLoad(const std::vector<BlockSpan>& spans) const;
  std::vector<VertexBox> FindBoxes(const std::vector<BlockSpan>& spans, std::size_t rank) const;
  std::vector<PendingBlock> MakeBlocks(const BlockSpan& span) const;
  /// Fills the records of a round's blocks. Those that stay on this rank are finished at once.
  /// `whenFinished` is called for each by its index, by several threads at once.
  Status MakeRecords(const std::vector<BlockSpan>& spans, RoundSamples samples,
    const BlockRoundsSteps& steps, std::vector<PendingBlock>& blocks,
    const std::function<void(std::size_t)>& whenFinished);
  Status Ship(const BlockRoundsSteps& steps, std::vector<PendingBlock>& blocks);
  /// Makes the records of a round and starts writing them; those before are written then. Agrees.
  Status WorkOnRound(const BlockRoundsSteps& steps, Round round, RoundSamples samples,
    std::shared_ptr<RoundWriting>& writing);
  /// The same for a rank that works alone: it writes blocks while it makes others.
  Status WorkAlone(const BlockRoundsSteps& steps, Round round, RoundSamples samples,
    std::shared_ptr<RoundWriting>& writing);
  std::shared_ptr<RoundWriting> StartWriting(const BlockRoundsSteps& steps,
    std::vector<PendingBlock> blocks, const std::shared_ptr<RoundWriting>& before);

  Communicator& Ranks;
  BoxSource& Source;
  const BlockGrid& Grid;
  const std::vector<ValueType>& Types;
  const BlockExchange& Exchange;
  const BlockShipment& Shipment;
  RoundPlan& Plan;
  int Threads;
  std::size_t Rank;
  std::uint64_t MemoryBytes;
  std::uint64_t RecordBytes; ///< of the largest block
  RecordBuffers Records;
  std::int64_t BlocksAtOnce; ///< of each rank in a round
  std::uint64_t Rounds = 0;
  std::uint64_t LargestBytes = 0;
};

} // namespace isosurface

#endif
