// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RoundWriting_h
#define isosurface_RoundWriting_h

#include "Ground/Base/Status.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/RecordBuffers.h"

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

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

} // namespace isosurface

#endif
