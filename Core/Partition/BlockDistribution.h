// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockDistribution_h
#define isosurface_BlockDistribution_h

#include "Partition/BlockProfile.h"
#include "Volume/ValueKey.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// How blocks are spread over stores.
enum class DistributionMethod : std::uint8_t
{
  Greedy,  ///< blocks of similar value ranges are dealt round robin
  Random,  ///< a seeded hash of the block index
  Slab,    ///< contiguous runs of block indices; unbalanced, for comparison
  Balanced ///< every store gets an equal share of the estimated triangles at every isovalue
};

/// "greedy", "random", "slab", "balanced", as the file header has it; and back.
const char* GetDistributionName(DistributionMethod method);
std::optional<DistributionMethod> FindDistribution(const std::string& name);

/**
 * The store of every block: result[b] in [0, stores) for block index b, from the ranges of the
 * blocks' values. Depends on nothing but its arguments, so that any number of ranks finds the same.
 * stores >= 1; there may be more of them than blocks. `seed` matters to Random only.
 *
 * Greedy (section 4.1.1.2 of X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive
 * datasets on commodity off-the-shelf clusters", 2009): a block of values [x, y] falls into the
 * element [(x - Vmin) / a, (y - x) / a] of a triangular matrix of the range space, a = (Vmax -
 * Vmin) / GreedyElements; the blocks of an element are sorted by decreasing range and dealt round
 * robin. Deviations: one sort of all blocks instead of one a processor, and a dealing counter that
 * goes on from element to element: the result does not depend on the number of ranks, no store is
 * favoured, and the stores' numbers of blocks differ by at most 1. Blocks of one single value,
 * which no isosurface passes, are dealt last. Random: section 4.1.1.3 there. Balanced: by
 * `profiles`, one a block, which the other methods do without; see BlockBalancer.h.
 *
 * Cost: O(n log n) for n blocks (Greedy), 24 bytes a block; of Balanced, see there.
 */
std::vector<std::uint32_t> DistributeBlocks(DistributionMethod method, ValueType type,
  const std::vector<KeyRange>& ranges, std::uint32_t stores, std::uint64_t seed,
  const std::vector<BlockProfile>& profiles = {});

/// Segments of the value range in Greedy's matrix.
constexpr std::uint32_t GreedyElements = 256;

} // namespace isosurface

#endif
