// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_QueryPlan_h
#define isosurface_QueryPlan_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Sharing/BlockClaims.h"
#include "Storage/Store/VolumeLayout.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace isosurface
{

/// An isosurface of a blocked volume; equal on all ranks unless stated otherwise.
struct SurfaceQuery : BlockQuery
{
  int Rank = 0; ///< whose share is extracted; differs from rank to rank
  int Ranks = 1;
  std::vector<std::size_t> Attributes = {}; ///< arrays to interpolate
};

/// Which blocks a rank reads, each from which store, and from which replica of it first.
struct QueryPlan
{
  std::vector<BlockReference> Blocks; ///< by share, in each by store and ordinal
  std::vector<std::size_t> Firsts;    ///< of each share in Blocks, then the number of all blocks
  std::size_t Own = 0;                ///< which of these shares is this rank's

  std::size_t GetOwnBegin() const { return this->Firsts[this->Own]; }
  std::size_t GetOwnEnd() const { return this->Firsts[this->Own + 1]; }
};

/// Whose shares a plan has.
enum class PlannedShares
{
  Own, ///< no rank takes blocks of another one
  All  ///< the share is where a rank begins: then it claims blocks of others (BlockClaims)
};

/**
 * Finds the blocks that an isosurface of one of the isovalues crosses (some samples are >= the
 * isovalue, some are not), each once, and decides which rank reads which. They are those blocks
 * that have the given level (FindLevel), and active at the finest level there, GetSpectrumLevel();
 * at a coarser one some may be empty. The selection adds blocks and leaves blocks out before ranks
 * share them. No rank needs a message from another one.
 *
 * P ranks share D stores in one of three ways:
 * - Each rank reads stores of its own: with P <= D, rank r takes the stores d with d mod P == r;
 *   with P > D, the ranks r with r mod D == d share store d, and each takes a contiguous run of the
 *   active blocks in the order of their ordinals.
 * - With replicas a rank also reads those in its stores' folders. The work of each store, which
 *   the spectra tell, is balanced over the ranks that have a replica (BalanceReplicas).
 * - Where every rank reaches every store (not BlockedVolume::HasLocalStores) the active blocks of
 *   all stores are dealt (BlockDealing). If there are more than 64 stores, and at least as many as
 *   ranks, ranks share whole stores nevertheless. Replicas are chosen so that all stores have the
 *   same work.
 * PlannedShares::All deals always.
 *
 * A replica that is lost or damaged is noticed when it is read, and another one is read instead, if
 * this rank reaches one; results are the same (RunWithReplicas).
 *
 * Errors: those of BlockedVolume; InvalidArgument for a rank that there is not. Cost: for each store
 * that is searched, a tree query an isovalue, and the directory pages of the reported blocks.
 * Dealing searches all stores. See BlockedVolume::FindActiveBlocks for selections.
 */
Result<QueryPlan> PlanQuery(BlockedVolume& volume, const SurfaceQuery& query, int level,
  QueryStatistics& statistics, PlannedShares shares = PlannedShares::Own);

/// The counters by which ranks claim blocks of a query; null on all ranks if there is one rank, or
/// if one cannot share its blocks: then each extracts its share. Collective.
std::unique_ptr<SharedCounters> MakeClaimCounters(
  Communicator& ranks, const BlockedVolume& volume, const SurfaceQuery& query);

} // namespace isosurface

#endif
