// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockBalancer_h
#define isosurface_BlockBalancer_h

#include "Storage/Distribution/BlockProfile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Spreads blocks over stores such that all stores have the same estimated triangles and the same
 * active blocks at every isovalue: DistributionMethod::Balanced. Takes the blocks by decreasing
 * work and gives each to the store with the minimum of
 *
 *     sum over isovalues k of  (load[store][k] / mean[k])^2 * work[block][k] / mean[k]
 *
 * plus the same sum, with the weight ActiveWeight, for active blocks; then of the number of blocks.
 * Work is the number of cubes that the isosurface crosses (BlockProfile).
 *
 * Source: vector bin packing in decreasing order, after R. Graham, "Bounds on multiprocessing
 * timing anomalies", 1969. The aim is that of section 4.1.1.1 of X. Zhang, C. Bajaj, "Scalable
 * isosurface visualization of massive datasets on commodity off-the-shelf clusters", 2009.
 *
 * The result depends on the arguments only. Cost: a multiplication for each block, store and
 * isovalue: seconds for 262,144 blocks and 1,024 stores. Memory: 12 bytes a block, 512 a store.
 */
class BlockBalancer
{
public:
  /// The maximum number of isovalues that are balanced, closer together where there is more work.
  static constexpr std::size_t Isovalues = 64;
  /// Isovalues with fewer cubes a store (about 500 triangles) are left out.
  static constexpr double MinimumCubes = 12;
  /// The weight of active blocks, relative to that of work.
  static constexpr double ActiveWeight = 0.6;

  BlockBalancer(const std::vector<BlockProfile>& profiles, std::uint32_t stores);

  /// The memory for the loads of the stores.
  static std::uint64_t GetBytes(std::uint32_t stores) { return stores * (8 * Isovalues + 8); }

  /// The store of every block.
  std::vector<std::uint32_t> Distribute();

private:
  /// One block's work at the isovalues [Begin, End), divided by the mean of a store.
  struct Work
  {
    std::size_t Begin = 0;
    std::size_t End = 0;
    std::vector<float> Cubes;
  };

  std::vector<double> FindCandidates() const;
  void ChooseIsovalues();
  void FindMeans();
  Work GetWork(std::size_t block) const;
  std::vector<std::uint32_t> SortBlocks() const;
  std::uint32_t ChooseStore(const Work& work);

  const std::vector<BlockProfile>& Profiles;
  std::uint32_t Stores;
  std::vector<double> Values;     ///< the isovalues, increasing
  std::vector<double> MeanCubes;  ///< mean of the stores, by isovalue
  std::vector<float> ActiveLoad;  ///< of one block, relative to the mean of the stores, weighted
  std::vector<float> CubeLoads;   ///< [isovalue][store]
  std::vector<float> ActiveLoads; ///< [isovalue][store]
  std::vector<float> Sums;        ///< that are compared, by store
  std::vector<std::uint32_t> Numbers; ///< of blocks, by store
};

} // namespace isosurface

#endif
