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
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * An array of Zarr 2, Zarr 3 or N5 in a folder. Chunks that do not exist have the fill value. A chunk
 * that a box touches is decoded; those of which a box needs a part are kept as long as the cache has
 * room, because the next box probably needs the rest.
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

  std::string MakeKey(const Numbers& file) const;
  Status MakeError(const std::string& path, const std::string& reason) const;
  /// Memory for decoded samples. Large chunks are not of the heap, which would not give them back.
  Result<Samples> Allocate(std::size_t bytes);
  /// A chunk as it is stored, of the cache if it is there.
  Result<Samples> TakeChunk(const Numbers& chunk, bool isKept);
  Result<Samples> LoadChunk(const Numbers& chunk);
  Result<Samples> LoadFromN5(const RandomAccessFile& file);
  /// Finds the bytes of a chunk in a shard; an empty range if the chunk does not exist.
  Status FindInShard(const RandomAccessFile& file, const Numbers& shard, const Numbers& chunk,
    std::uint64_t& offset, std::uint64_t& size);
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
  std::shared_ptr<PageBufferPool> Pool;
  Bytes Encoded;
  std::list<Entry> Cache; ///< the last one used first
  std::map<Numbers, std::list<Entry>::iterator> Cached;
  Numbers IndexShard;                                         ///< whose index is Index
  std::vector<std::pair<std::uint64_t, std::uint64_t>> Index; ///< offsets and sizes in the shard
};

} // namespace isosurface

#endif
