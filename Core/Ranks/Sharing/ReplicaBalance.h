// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ReplicaBalance_h
#define isosurface_ReplicaBalance_h

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Who may serve the blocks of a store, and with which of its replicas.
struct ReplicaServer
{
  std::uint32_t Server = 0; ///< a rank, or the store whose folder has the replica
  std::uint32_t Replica = 0;
};

/**
 * Shares the work of each store among the servers of its replicas so that the maximum of the
 * servers' work becomes as small as possible, or does not exceed their mean by more than
 * `tolerance` of it. Servers with too much give to others, across several stores where necessary
 * (chained declustering), so a lost replica costs all servers a little. What need not move stays
 * with the first server of its store.
 *
 * `work`: per store. `servers`: per store, in the order of preference, not empty, no server twice.
 * `count`: how many servers there are. Returns per store the work of each of its servers, which add
 * up to that of the store. Integers only, so that all ranks get the same. Cost: at most 64 searches
 * a server through all servers of all stores.
 */
std::vector<std::vector<std::uint64_t>> BalanceReplicas(const std::vector<std::uint64_t>& work,
  const std::vector<std::vector<ReplicaServer>>& servers, std::size_t count,
  double tolerance = 1.0 / 256);

/**
 * A tolerance that pays: since the triangles of a block are not known, a part of a store's blocks
 * has more or less work than its share of the blocks, by half a mean store's work over the root of
 * its blocks or so. `blocks`: active ones of all stores.
 */
double FindTolerance(std::uint64_t blocks, std::size_t servers);

/**
 * The server of each block of a store, as an index into its `shares`: each serves a part of the
 * blocks in proportion to `shares`, to the nearest block. Blocks are taken in an order that mixes
 * their ordinals, so a block seldom changes its server when the isovalue changes a little.
 */
std::vector<std::uint32_t> ShareBlocks(
  const std::vector<std::uint32_t>& ordinals, const std::vector<std::uint64_t>& shares);

} // namespace isosurface

#endif
