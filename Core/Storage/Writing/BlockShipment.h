// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockShipment_h
#define isosurface_BlockShipment_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/RecordBuffers.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Brings whole records from the ranks that made them to the ranks that write them: rank r of P
 * writes the stores d with d mod P == r. One message for each pair of ranks and round:
 *
 *     message: blocks, one after another
 *     +----+-------------------------------------+
 *     |  0 | block index                (uint64) |
 *     |  8 | record, without its padding         |
 *     +----+-------------------------------------+
 */
class BlockShipment
{
public:
  /// stores[block]: where each block of the volume belongs. The references must outlive this.
  BlockShipment(const BlockGrid& grid, const std::vector<ValueType>& types,
    const std::vector<std::uint32_t>& stores, std::size_t rank, std::size_t ranks)
    : Grid(grid)
    , Types(types)
    , Stores(stores)
    , Rank(rank)
    , Ranks(ranks)
  {
  }

  std::uint32_t FindStore(std::int64_t block) const
  {
    return this->Stores[static_cast<std::size_t>(block)];
  }
  std::size_t FindWriter(std::int64_t block) const
  {
    // There is at least one rank. NOLINTNEXTLINE(clang-analyzer-core.DivideZero)
    return this->FindStore(block) % this->Ranks;
  }

  /// The blocks of a round that this rank sends to others, receives from them, and keeps. Rank r
  /// makes the records of spans[r].
  struct Load
  {
    std::uint64_t Sent = 0;
    std::uint64_t Received = 0;
    std::uint64_t Kept = 0;
  };
  Load GetLoad(const std::vector<BlockSpan>& spans) const;

  /// Packs the messages to all ranks. The blocks that this rank writes stay in `blocks`.
  std::vector<Message> Pack(std::vector<PendingBlock>& blocks, RecordBuffers& buffers) const;

  /// Adds the blocks that other ranks sent, and sorts all by block index. Frees each message.
  Status Unpack(std::vector<Message>& messages, std::vector<PendingBlock>& blocks,
    RecordBuffers& buffers) const;

private:
  const BlockGrid& Grid;
  const std::vector<ValueType>& Types;
  const std::vector<std::uint32_t>& Stores;
  std::size_t Rank;
  std::size_t Ranks;
};

} // namespace isosurface

#endif
