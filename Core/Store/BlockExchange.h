// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockExchange_h
#define isosurface_BlockExchange_h

#include "Base/Buffer.h"
#include "Base/Communicator.h"
#include "Base/Status.h"
#include "Store/BlockRecord.h"
#include "Store/BlockSegment.h"
#include "Store/BlockedVolumeWriter.h"
#include "Volume/BlockGrid.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A block whose record this rank is to fill and write.
struct PendingBlock
{
  PendingBlock(const BlockGrid& grid, std::int64_t block, std::uint32_t store,
    const std::vector<ValueType>& types);

  std::int64_t Block;
  std::uint32_t Store;
  BlockRecordLayout Layout;
  Buffer<std::uint8_t> Record; ///< padded; segments without their headers until they are sealed
};

/**
 * Brings the samples of blocks from the ranks that have them to the ranks that write the blocks.
 *
 * What a rank has itself it takes from its own piece. The rest comes from the vertices' owners
 * (PieceOwnership.h), one message a pair of ranks and round:
 *
 *     message: parts, one after another
 *     +----+------------------------------------------------+
 *     |  0 | block index                          (uint64)   |
 *     |  8 | level                                (uint32)   |
 *     | 12 | 0                                    (uint32)   |
 *     | 16 | part: low x, y, z, high x, y, z      (int64)    |   in the level's coordinates
 *     | 64 | the samples of the segment in the part, in its order, array after array
 *     +----+------------------------------------------------+
 */
class BlockExchange
{
public:
  /// Where a block goes.
  struct Target
  {
    std::int64_t Block;
    int Rank;
  };

  /// `pieces`: the boxes of all ranks; `owned`: what this rank is to supply. The references must
  /// outlive this object.
  BlockExchange(Communicator& communicator, const BlockGrid& grid,
    const std::vector<ValueType>& types, const VolumePiece& piece,
    const std::vector<VertexBox>& pieces, const std::vector<VertexBox>& owned, int threads);

  /// The messages to all ranks with this rank's samples of some blocks, sorted by block index.
  std::vector<Message> Pack(const std::vector<Target>& round) const;

  /// Fills the records of this rank's blocks, sorted by block index, from its own piece and from
  /// the messages of all ranks. Fails if the samples do not add up.
  Status Fill(std::vector<PendingBlock>& blocks, const std::vector<Message>& messages) const;

private:
  void PackBlock(std::int64_t block, const std::vector<VertexBox>& boxes, Message& message) const;
  void FillFromPiece(PendingBlock& block, std::atomic<std::uint64_t>& samples) const;
  Status FillFromMessage(std::vector<PendingBlock>& blocks, const Message& message,
    std::atomic<std::uint64_t>& samples) const;

  const BlockGrid& Grid;
  const std::vector<ValueType>& Types;
  const VolumePiece& Piece;
  int Threads;
  int Rank;
  /// Per rank: what it has to be sent from here.
  std::vector<std::vector<VertexBox>> ToSend;
};

} // namespace isosurface

#endif
