// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockClaims_h
#define isosurface_BlockClaims_h

#include "Ground/Base/SharedCounters.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockQueue.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * The blocks that one of several ranks extracts if ranks that are ready take blocks from others'
 * shares: its own share from the front, then, always from the rank with the most blocks left, some
 * from the back. All ranks know all shares. What is left of a share is one counter of that rank:
 * how many blocks its owner has claimed from the front, and how many others have from the back, in
 * half of the bits each. A claim adds to the counter in one step; the value before the addition
 * tells which blocks are claimed. So each block is claimed once, and no rank waits for another.
 *
 * Claims become smaller towards the end: a rank that becomes slow keeps what it has claimed. Cost:
 * a claim of the own share is one addition to the own counter, for a sixteenth of what is left, at
 * most four blocks a thread; one of another share reads the counters of the ranks that had blocks
 * left, too, for a part of the share by twice the number of ranks, at most 32 blocks a thread.
 */
class BlockClaims : public BlockQueue
{
public:
  /// `firsts`: the number of the first block of each rank's share, then that of all blocks; each
  /// share has less than 2^31. `announce` is told of blocks [begin, end) of others' shares that
  /// this rank has claimed; may be empty. The counters must outlive this object.
  BlockClaims(SharedCounters& counters, int rank, std::vector<std::size_t> firsts, int threads,
    std::function<void(std::size_t begin, std::size_t end)> announce = {});

  Result<std::vector<std::size_t>> Take() override;
  /// This rank's share.
  std::size_t GetExpectedBlocks() const override { return this->GetSize(this->Rank); }
  void LetOthersIn() override { this->Counters.LetOthersIn(); }

  /// Claims all that is left of a rank's own share: the rank has failed, so there will be no
  /// surface, and no rank needs to extract the share.
  static void Withdraw(SharedCounters& counters, int rank);

private:
  /// [begin, end), counted in a share.
  using Range = std::pair<std::size_t, std::size_t>;

  std::size_t GetSize(int rank) const
  {
    const auto number = static_cast<std::size_t>(rank);
    return this->Firsts[number + 1] - this->Firsts[number];
  }
  /// What a counter leaves of a rank's share.
  Range FindLeft(int rank, std::uint64_t counter) const;
  Result<Range> ClaimOwn();
  Result<Range> ClaimOf(int rank, std::size_t left);
  /// Reads the counters of the other ranks that had blocks left. The rank with the most, and how
  /// many; -1 if there is none.
  Result<std::pair<int, std::size_t>> FindMost();
  std::vector<std::size_t> List(int rank, const Range& range) const;

  SharedCounters& Counters;
  const int Rank;
  const std::vector<std::size_t> Firsts;
  const std::size_t Threads;
  const std::function<void(std::size_t begin, std::size_t end)> Announce;
  std::size_t OwnLeft;     ///< at the last claim
  std::vector<int> Others; ///< that had blocks left
};

} // namespace isosurface

#endif
