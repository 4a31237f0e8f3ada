// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCache_h
#define isosurface_BlockCache_h

#include "Base/Buffer.h"
#include "Base/Status.h"
#include "Volume/SampleView.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/**
 * The samples of one array of one block at one level, x fastest. View.Box is the block's own
 * vertices, View.Available those and the ghost layer, both in the level's vertex coordinates
 * (BlockGrid); View points into Bytes.
 */
struct DecodedBlock
{
  std::int64_t Block = 0;
  int Level = 0;
  SampleView View;
  Buffer<std::uint8_t> Bytes;
};
using DecodedBlocks = std::vector<std::shared_ptr<const DecodedBlock>>;

/// What a decoded block is known by.
struct BlockCacheKey
{
  std::uint64_t Dataset = 0; ///< a hash of path, time step's folder and contents
  std::int64_t Block = 0;
  std::uint32_t Array = 0;
  std::uint32_t Level = 0;

  bool operator==(const BlockCacheKey& other) const
  {
    return this->Dataset == other.Dataset && this->Block == other.Block &&
      this->Array == other.Array && this->Level == other.Level;
  }
};

/**
 * Decoded blocks, kept in memory up to a budget of bytes; the least recently used ones go first. A
 * block that somebody still holds lives on after it has left the cache. Safe for use by any number
 * of threads; a block that several threads ask for at once is loaded once.
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

  /// The one of this process, which outlives every reader; its budget is 1 GiB until it is set.
  static const std::shared_ptr<BlockCache>& GetProcessCache();

  /// Returns the block, calling `load` if it is not here; `hit` tells whether it was. A failed load
  /// is not kept: the next one to ask tries anew.
  Result<std::shared_ptr<const DecodedBlock>> Get(
    const BlockCacheKey& key, const Loader& load, bool& hit);

  /// Whether the block is here, or on its way; by the time of the answer it may be gone.
  bool Contains(const BlockCacheKey& key) const;

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
  struct Loading
  {
    bool Done = false;
    std::shared_ptr<const DecodedBlock> Block;
    Status Error;
  };

  void Insert(const BlockCacheKey& key, const std::shared_ptr<const DecodedBlock>& block);
  void Trim(std::uint64_t budget);

  mutable std::mutex Mutex;
  std::condition_variable LoadingDone;
  std::uint64_t Budget;
  std::uint64_t Size = 0;
  std::list<Entry> Entries; ///< the most recently used one first
  std::unordered_map<BlockCacheKey, std::list<Entry>::iterator, KeyHash> Index;
  std::unordered_map<BlockCacheKey, std::shared_ptr<Loading>, KeyHash> InFlight;
};

} // namespace isosurface

#endif
