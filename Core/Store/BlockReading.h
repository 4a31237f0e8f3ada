// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockReading_h
#define isosurface_BlockReading_h

#include "Store/BlockStore.h"
#include "Store/BlockedVolume.h"

#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <vector>

namespace isosurface
{

/// Reads variables of one block at one level, each through the block cache.
class BlockedVolume::BlockReading
{
public:
  BlockReading(BlockedVolume& volume, const BlockReference& reference, std::size_t timeStep,
    const StoredLevel& stored, QueryStatistics& statistics)
    : Volume(volume)
    , Reference(reference)
    , TimeStep(timeStep)
    , Stored(stored)
    , Statistics(statistics)
  {
  }

  /// Tells beforehand what will be asked for, so that one read can bring several components.
  void Announce(const std::vector<std::size_t>& variables);

  Result<std::shared_ptr<const DecodedBlock>> Get(std::size_t variable);

  /// What will be read for the announced variables.
  void FindRanges(const BlockStore& store, std::vector<BlockStore::ByteRange>& ranges) const;

private:
  using Block = std::shared_ptr<const DecodedBlock>;

  BlockCacheKey MakeKey(std::size_t variable) const
  {
    return this->Volume.MakeKey(this->Reference.Block, this->TimeStep, variable, this->Stored);
  }
  /// The end of the components from this one on that one read brings. At a coarser level what lies
  /// between them is not worth reading.
  std::size_t FindEndOfRead(std::size_t component) const;
  bool IsCached(std::size_t variable) const
  {
    return this->Volume.Cache->Contains(this->MakeKey(variable));
  }
  Result<Block> ReadComponent(std::size_t component);
  Result<Block> MakeMagnitude(std::size_t array);

  BlockedVolume& Volume;
  const BlockReference& Reference;
  std::size_t TimeStep;
  StoredLevel Stored;
  QueryStatistics& Statistics;
  std::set<std::size_t> Asked;        ///< variables
  std::set<std::size_t> Needed;       ///< the components among them, and those of magnitudes
  std::map<std::size_t, Block> Found; ///< components that were read
};

} // namespace isosurface

#endif
