// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockReading_h
#define isosurface_BlockReading_h

#include "Ground/Base/Status.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockReference.h"
#include "Storage/Store/BlockStore.h"
#include "Storage/Store/QueryStatistics.h"
#include "Storage/Store/StoreRecords.h"
#include "Storage/Store/VolumeStores.h"

#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <vector>

namespace isosurface
{

/// Reads variables of one block at one level, each through the block cache.
class BlockReading
{
public:
  /// The references must outlive this object.
  BlockReading(VolumeStores& stores, BlockCache& cache, const BlockReference& reference,
    std::size_t timeStep, const StoredLevel& stored, QueryStatistics& statistics)
    : Stores(stores)
    , Cache(cache)
    , Reference(reference)
    , TimeStep(timeStep)
    , Stored(stored)
    , Statistics(statistics)
  {
  }

  /// Declares the variables that Get() will be called for, so that one read can fetch several
  /// components.
  void Announce(const std::vector<std::size_t>& variables);

  Result<std::shared_ptr<const DecodedBlock>> Get(std::size_t variable);

  /// Adds the ranges of bytes that will be read for the announced variables.
  void FindRanges(const BlockStore& store, std::vector<StoreRecords::ByteRange>& ranges) const;

private:
  using Block = std::shared_ptr<const DecodedBlock>;

  BlockCacheKey MakeKey(std::size_t variable) const
  {
    return this->Stores.GetLayout().MakeKey(
      this->Reference.Block, this->TimeStep, variable, this->Stored);
  }
  bool IsCached(std::size_t variable) const
  {
    return this->Cache.Contains(this->MakeKey(variable));
  }
  /// Returns the end of the components from `component` on that one read fetches. At levels
  /// above 0 a read fetches `component` alone, since the bytes between components are not needed.
  std::size_t FindEndOfRead(std::size_t component) const;
  /// Also reads the next components of the record, if they are announced.
  Result<Block> ReadComponent(std::size_t component);
  Result<Block> MakeMagnitude(std::size_t array);

  VolumeStores& Stores;
  BlockCache& Cache;
  const BlockReference& Reference;
  std::size_t TimeStep;
  StoredLevel Stored;
  QueryStatistics& Statistics;
  std::set<std::size_t> Announced;    ///< variables
  std::set<std::size_t> Needed;       ///< the components among them, and those of magnitudes
  std::map<std::size_t, Block> Found; ///< components that were read
};

} // namespace isosurface

#endif
