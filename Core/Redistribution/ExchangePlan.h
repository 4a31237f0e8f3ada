// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExchangePlan_h
#define isosurface_ExchangePlan_h

#include "Base/Communicator.h"
#include "Base/Status.h"
#include "Redistribution/BlockDescription.h"
#include "Volume/GridGeometry.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Which block goes where and when, as one rank needs it: computed by each from what all say of
 * their blocks, so that the sizes of all messages are known before the first one is sent.
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

  std::vector<OwnBlock> Own;                      ///< in the order in which they were described
  std::vector<IncomingBlock> Incoming;            ///< by place: z, y, x
  std::vector<std::vector<std::size_t>> BySource; ///< of each rank, its places in Incoming as sent
  std::size_t Rounds = 0;                         ///< of the rank that has most

  /// What one rank tells all others of its blocks. Of each: axis by axis, the low vertex, the
  /// number of vertices, and the lattice coordinate; the points by isovalue; the bytes. Numbers as
  /// in CodedNumbers.h.
  static Message Describe(const std::vector<BlockDescription>& blocks);

  /**
   * messages: those of all ranks; blocks go to the ranks 0 to parts - 1, see MakeCompactPartition.
   * Errors: Corrupt. Cost: memory about 120 bytes a block of all ranks, let go in the end but for
   * the blocks that `rank` sends and gets.
   */
  static Result<ExchangePlan> Make(const std::vector<Message>& messages, std::size_t rank,
    const GridGeometry& geometry, std::size_t isovalues, std::uint32_t parts,
    std::uint64_t roundBytes);
};

} // namespace isosurface

#endif
