// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrArray_h
#define isosurface_ZarrArray_h

#include "Base/FileSystem.h"
#include "Source/ZarrMetadata.h"

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
  std::uint64_t GetHeldBytes() const override;
  Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) override;

private:
  using Bytes = std::vector<std::uint8_t>;
  struct Entry
  {
    Numbers Chunk;
    std::shared_ptr<const Bytes> Samples;
  };

  std::string MakeKey(const Numbers& file) const;
  Status MakeError(const std::string& path, const std::string& reason) const;
  /// The decoded samples of a chunk, as they are stored; null if the chunk does not exist.
  Result<std::shared_ptr<const Bytes>> GetChunk(const Numbers& chunk, bool isKept);
  Result<std::shared_ptr<const Bytes>> LoadChunk(const Numbers& chunk);
  Result<std::shared_ptr<const Bytes>> LoadFromN5(const RandomAccessFile& file);
  /// Finds the bytes of a chunk in a shard; an empty range if the chunk does not exist.
  Status FindInShard(const RandomAccessFile& file, const Numbers& shard, const Numbers& chunk,
    std::uint64_t& offset, std::uint64_t& size);
  Result<std::shared_ptr<const Bytes>> Decode(
    const RandomAccessFile& file, std::uint64_t offset, std::uint64_t size, std::size_t decoded);
  /// Copies what a chunk and a box have in common.
  void CopyChunk(const Bytes* samples, const Numbers& chunk, const Numbers& low,
    const Numbers& size, std::uint8_t* to) const;

  FileSystem& Files;
  std::string Folder;
  ZarrMetadata Metadata;
  std::size_t StoredSize; ///< bytes of a sample in a chunk
  std::size_t ChunkBytes;
  std::size_t CacheBytes;
  std::list<Entry> Cache; ///< the last one used first
  std::map<Numbers, std::list<Entry>::iterator> Cached;
  Numbers IndexShard;                                         ///< whose index is Index
  std::vector<std::pair<std::uint64_t, std::uint64_t>> Index; ///< offsets and sizes in the shard
};

} // namespace isosurface

#endif
