// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrArray_h
#define isosurface_ZarrArray_h

#include "Formats/Zarr/ZarrMetadata.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/PageBuffer.h"

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * An array of Zarr 2, Zarr 3 or N5 in a folder. Chunks that do not exist have the fill value. A chunk
 * that a box touches is decoded; those of which a box needs a part are kept as long as the cache has
 * room, because the next box probably needs the rest. Of an address, several chunks are fetched at once.
 */
class ZarrArray : public StoredArray
{
public:
  /// `files` must outlive the array.
  ZarrArray(FileSystem& files, std::string folder, ZarrMetadata metadata, std::uint64_t cacheBytes);

  const std::string& GetName() const override { return this->Folder; }
  const Numbers& GetShape() const override { return this->Metadata.Shape; }
  ValueType GetType() const override { return this->Metadata.Type; }
  Numbers GetChunk() const override { return this->Metadata.Chunk; }
  bool DecodesInParallel() const override { return true; }
  std::uint64_t GetCacheBytes() const override { return this->CacheBytes; }
  std::uint64_t GetHeldBytes() const override;
  Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) override;

private:
  using Bytes = std::vector<std::uint8_t>;
  /// The decoded samples of a chunk; null if the chunk does not exist.
  using Samples = std::shared_ptr<std::uint8_t>;
  struct Entry
  {
    Numbers Chunk;
    Samples Decoded;
  };
  /// A chunk that a box needs.
  struct Wanted
  {
    Numbers Chunk;
    bool IsPart = false; ///< kept: the rest is there, but not asked for
  };
  struct Shard
  {
    std::mutex Mutex; ///< of what follows
    bool IsOpened = false;
    std::shared_ptr<RandomAccessFile> File; ///< null if the shard does not exist
    std::vector<std::pair<std::uint64_t, std::uint64_t>> Index; ///< offsets and sizes
  };

  std::string MakeKey(const Numbers& file) const;
  Status MakeError(const std::string& path, const std::string& reason) const;
  /// Memory for decoded samples. Large chunks are not of the heap, which would not give them back.
  Result<Samples> Allocate(std::size_t bytes);
  /// Copies a chunk, of the cache if it is there, to a box. Any thread may call it.
  Status TakeChunk(const Wanted& wanted, const Numbers& low, const Numbers& size, std::uint8_t* to);
  void KeepChunk(const Numbers& chunk, const Samples& samples);
  /// A chunk as it is stored. Any thread may call it.
  Result<Samples> LoadChunk(const Numbers& chunk);
  /// What is to be read first of a file: the index of a shard, or all of a chunk.
  std::int64_t FindFirstPart() const;
  std::size_t CountInShard() const;
  std::size_t CountIndexBytes() const;
  /// The shard with its index.
  Result<std::shared_ptr<Shard>> OpenShard(const Numbers& number);
  Result<Samples> LoadFromN5(const RandomAccessFile& file);
  Status ReadIndex(Shard& shard) const;
  Result<Samples> LoadFromShard(const Numbers& number, const Numbers& chunk);
  Result<Samples> Decode(
    const RandomAccessFile& file, std::uint64_t offset, std::uint64_t size, std::size_t decoded);
  /// Copies what a chunk and a box have in common.
  void CopyChunk(const std::uint8_t* samples, const Numbers& chunk, const Numbers& low,
    const Numbers& size, std::uint8_t* to) const;

  FileSystem& Files;
  std::string Folder;
  ZarrMetadata Metadata;
  std::size_t StoredSize; ///< bytes of a sample in a chunk
  std::size_t ChunkBytes;
  std::size_t CacheBytes;
  std::size_t AtOnce = 1; ///< chunks that are loaded at the same time
  std::shared_ptr<PageBufferPool> Pool;
  std::mutex Mutex;       ///< of what follows
  std::list<Entry> Cache; ///< the last one used first
  std::map<Numbers, std::list<Entry>::iterator> Cached;
  std::map<Numbers, std::shared_ptr<Shard>> Shards;
};

} // namespace isosurface

#endif
