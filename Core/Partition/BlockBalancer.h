// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockBalancer_h
#define isosurface_BlockBalancer_h

#include "Partition/BlockProfile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Spreads blocks over stores such that every store has an equal share of the estimated triangles
 * and of the active blocks at every isovalue: DistributionMethod::Balanced. The blocks, by
 * decreasing work, go one by one to the store that has least where the block has work, i.e. that
 * makes the sum over stores and isovalues of the squared normalised loads grow least:
 *
 *   sum over isovalues k in the block's span of  load[store][k] / mean[k] * work[block][k] /
 * mean[k]
 *
 * (and the same, with a smaller weight, for the number of active blocks). At equal sums the store
 * of fewer blocks takes it; blocks without work follow last, to the stores of fewest blocks.
 *
 * Work is the number of cubes that the isosurface passes (BlockProfile), taken at Isovalues
 * isovalues, which lie closer where there is more of it. Isovalues of less than MinimumCubes cubes
 * a store are left out.
 *
 * Source: vector bin packing in decreasing order, after T. Graham, "Bounds on multiprocessing
 * timing anomalies", 1969; the aim, stores whose spectra are scaled copies of the whole one, is
 * section 4.1.1.1 of X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive datasets on
 * commodity off-the-shelf clusters", 2009, which has no algorithm for it.
 *
 * Depends on its arguments alone. Cost: a multiplication a block, store and isovalue of the block's
 * span: seconds for 262,144 blocks and 1,024 stores. Memory: 12 bytes a block, 512 a store.
 */
class BlockBalancer
{
public:
  static constexpr std::size_t Isovalues = 64;
  /// Some 500 triangles.
  static constexpr double MinimumCubes = 12;
  /// The load that an active block is, against one of mean work.
  static constexpr double ActiveWeight = 0.6;

  BlockBalancer(const std::vector<BlockProfile>& profiles, std::uint32_t stores);

  /// The memory of the loads of so many stores.
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
  std::vector<double> Values;         ///< the isovalues, increasing
  std::vector<double> MeanCubes;      ///< a store, per isovalue
  std::vector<float> ActiveShare;     ///< of one active block in a store's mean, weighted
  std::vector<float> CubeLoads;       ///< [isovalue][store]
  std::vector<float> ActiveLoads;     ///< [isovalue][store]
  std::vector<float> Growth;          ///< per store
  std::vector<std::uint32_t> Numbers; ///< of blocks a store
};

} // namespace isosurface

#endif
