// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExchangePlan_h
#define isosurface_ExchangePlan_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ranks/Redistribution/BlockDescription.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

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
