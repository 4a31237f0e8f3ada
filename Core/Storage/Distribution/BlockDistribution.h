// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockDistribution_h
#define isosurface_BlockDistribution_h

#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Distribution/BlockProfile.h"

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
  Balanced ///< every store gets the same estimated triangles at every isovalue
};

/// The name in file headers: "greedy", "random", "slab", "balanced". Null: no method has this number.
const char* GetDistributionName(DistributionMethod method);
/// The method of that name; nothing if there is none.
std::optional<DistributionMethod> FindDistribution(const std::string& name);

/**
 * Chooses the store of every block: result[b] in [0, stores) for block b. `ranges`: the blocks'
 * value ranges; `stores` >= 1, may exceed the number of blocks; `seed`: for Random; `profiles`: one
 * for each block, for Balanced (see BlockBalancer.h). The result depends on the arguments only.
 *
 * Greedy: a block of values [x, y] belongs to the element [(x - Vmin) / a, (y - x) / a] of a
 * matrix, a = (Vmax - Vmin) / GreedyElements. Element by element, the blocks are sorted by
 * decreasing range and dealt round robin. Source: section 4.1.1.2 of X. Zhang, C. Bajaj, "Scalable
 * isosurface visualization of massive datasets on commodity off-the-shelf clusters", 2009 (Random:
 * 4.1.1.3). Deviations: all blocks are sorted together instead of those of each processor, and the
 * round robin continues from one element to the next, so the stores' numbers of blocks differ by at
 * most 1. Blocks of a single value are dealt last.
 *
 * Cost (Greedy): O(n log n) for n blocks, 24 bytes a block.
 */
std::vector<std::uint32_t> DistributeBlocks(DistributionMethod method, ValueType type,
  const std::vector<KeyRange>& ranges, std::uint32_t stores, std::uint64_t seed,
  const std::vector<BlockProfile>& profiles = {});

/// Segments of the value range in Greedy's matrix.
constexpr std::uint32_t GreedyElements = 256;

} // namespace isosurface

#endif
