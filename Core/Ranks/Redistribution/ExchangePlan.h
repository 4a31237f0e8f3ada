// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExchangePlan_h
#define isosurface_ExchangePlan_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ranks/Redistribution/ArrivingBlocks.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A block and the work of its surface, in any unit: points or triangles, for example.
struct WeighedBlock
{
  VertexBox Vertices;
  std::uint64_t Workload = 0;
};

/**
 * Assigns blocks to `pieces` pieces (at least 1) of about equal work, each compact in space:
 * bounding boxes of different pieces overlap by at most about a layer of blocks. Returns the piece
 * of each block; with fewer blocks than pieces some pieces are empty. No two blocks have the same
 * low vertex; spacing: that of the grid.
 *
 * Recursive coordinate bisection: M. Berger and S. Bokhari, "A partitioning strategy for nonuniform
 * problems on multiprocessors", 1987. Deviation: cuts balance work, not numbers, and may lie within a
 * layer of blocks. No piece has more work than the mean plus 1.3 times the heaviest block.
 *
 * The result depends on the set of blocks, not on their order. Cost: a sort of all blocks for each
 * doubling of the pieces; 12 bytes for each block.
 */
std::vector<std::uint32_t> MakeCompactPartition(const std::vector<WeighedBlock>& blocks,
  std::uint32_t pieces, const std::array<double, 3>& spacing);

/**
 * Which block goes where and when, as one rank needs it. Every rank computes it from the descriptions
 * of all blocks, so the sizes of all messages are known before the first one is sent.
 *
 * A rank sends its blocks in the order in which it described them. A round ends with the block by
 * which the rank has sent `roundBytes` in it.
 */
struct ExchangePlan
{
  struct OwnBlock
  {
    std::size_t Destination = 0;
    std::size_t Round = 0;
  };
  struct IncomingBlock
  {
    BlockDescription Description;
    std::size_t Source = 0;
    std::size_t Round = 0;
  };

  std::vector<OwnBlock> Own;           ///< in the order of their descriptions
  std::vector<IncomingBlock> Incoming; ///< in the order of their low vertices: by z, then y, then x
  std::vector<std::vector<std::size_t>>
    BySource;             ///< for each rank that sends, indices in Incoming in the order of sending
  std::size_t Rounds = 0; ///< the maximum of all ranks

  /// Packs the descriptions of a rank's blocks. For each block: for each axis low vertex, number of
  /// vertices, lattice coordinate; points for each isovalue; bytes. All are varints of Base/Coding.h.
  static Message Describe(const std::vector<BlockDescription>& blocks);

  /**
   * messages: by rank, what Describe made there; the same on all ranks. Blocks go to the ranks 0 to
   * pieces - 1, see MakeCompactPartition. isovalues: their number. Errors:
   * Corrupt. Memory: about 120 bytes for each block of all ranks, kept only for the blocks that `rank`
   * sends and receives.
   */
  static Result<ExchangePlan> Make(const std::vector<Message>& messages, std::size_t rank,
    const GridGeometry& geometry, std::size_t isovalues, std::uint32_t pieces,
    std::uint64_t roundBytes);
};

} // namespace isosurface

#endif
