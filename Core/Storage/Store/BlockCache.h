// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCache_h
#define isosurface_BlockCache_h

#include "Ground/Base/Status.h"
#include "Storage/Record/DecodedBlock.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace isosurface
{

/// Identifies a decoded block.
struct BlockCacheKey
{
  std::uint64_t Dataset = 0; ///< a time step of a volume, or of the source that has its samples
  std::int64_t Block = 0;
  std::uint32_t Variable = 0;
  std::uint32_t Level = 0;

  bool operator==(const BlockCacheKey& other) const
  {
    return this->Dataset == other.Dataset && this->Block == other.Block &&
      this->Variable == other.Variable && this->Level == other.Level;
  }
};

/**
 * Keeps decoded blocks in memory, up to a budget of bytes. The least recently used ones are evicted
 * first, but no block that the current query expects is evicted for one that it does not. So a
 * query larger than the budget finds some of its blocks at the next isovalue, where plain LRU would
 * evict each block just before it is needed. A block that a caller still holds outlives its
 * eviction. Safe for any number of threads; a block that several threads get at once is loaded once.
 */
class BlockCache
{
public:
  using Loader = std::function<Result<std::shared_ptr<const DecodedBlock>>()>;

  explicit BlockCache(std::uint64_t budget)
    : Budget(budget)
  {
  }
  BlockCache(const BlockCache&) = delete;
  BlockCache& operator=(const BlockCache&) = delete;

  /// The cache of this process, which outlives every reader. Its budget is 1 GiB until it is set.
  static const std::shared_ptr<BlockCache>& GetProcessCache();

  /// Returns the block, which `load` loads if it is not here; `hit` tells whether it was. An error
  /// is not kept: the next call loads anew.
  Result<std::shared_ptr<const DecodedBlock>> Get(
    const BlockCacheKey& key, const Loader& load, bool& hit);

  /// Declares the blocks that a query will ask for, in place of those of the query before. Cost:
  /// one search a key.
  void Expect(const std::vector<BlockCacheKey>& keys);

  /// Whether the block is here or being loaded. It may be evicted before the call returns.
  bool Contains(const BlockCacheKey& key) const;

  /// Counts the users of a dataset. When the last user goes, its blocks leave the cache: they can
  /// not be found any more. Blocks of a dataset without users are kept as any others. Cost of the
  /// last Release: a look at each entry.
  void Retain(std::uint64_t dataset);
  void Release(std::uint64_t dataset);

  /// In bytes; a lower one takes effect at once, 0 keeps nothing.
  void SetBudget(std::uint64_t budget);
  std::uint64_t GetBudget() const;
  /// Bytes held now, never above the budget.
  std::uint64_t GetSize() const;
  void Clear();

private:
  struct KeyHash
  {
    std::size_t operator()(const BlockCacheKey& key) const;
  };
  struct Entry
  {
    BlockCacheKey Key;
    std::shared_ptr<const DecodedBlock> Block;
    std::uint64_t Bytes = 0;
  };
  using EntryList = std::list<Entry>; ///< the most recently used one first
  struct Loading
  {
    bool Done = false;
    std::shared_ptr<const DecodedBlock> Block;
    Status Error;
  };

  /// Loads a block without holding the mutex, and tells those who wait for it.
  Result<std::shared_ptr<const DecodedBlock>> Load(
    const BlockCacheKey& key, const Loader& load, Loading& loading);
  EntryList& FindList(const BlockCacheKey& key);
  void Insert(const BlockCacheKey& key, const std::shared_ptr<const DecodedBlock>& block);
  void Trim(std::uint64_t budget);
  void RemoveOne();
  void RemoveDataset(std::uint64_t dataset, EntryList& entries);

  mutable std::mutex Mutex;
  std::unordered_map<std::uint64_t, std::size_t> Users; ///< of each dataset
  std::condition_variable LoadingDone;
  std::uint64_t Budget;
  std::uint64_t Size = 0;
  std::unordered_set<BlockCacheKey, KeyHash> Expected;
  EntryList ExpectedEntries;
  EntryList OtherEntries;
  std::unordered_map<BlockCacheKey, EntryList::iterator, KeyHash> Index;
  std::unordered_map<BlockCacheKey, std::shared_ptr<Loading>, KeyHash> InFlight;
};

} // namespace isosurface

#endif
