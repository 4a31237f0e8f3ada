// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChunkCacheSize_h
#define isosurface_ChunkCacheSize_h

#include "Formats/Source/StoredArray.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// What decoded chunks may take so that slabs do not decode a chunk again that they share.
struct ChunkCacheSize
{
  double ChunkBytes = 0;       ///< a decoded chunk
  std::size_t Bytes = 0;       ///< a slab of chunks and one more, or all that is allowed
  std::size_t Slots = 0;       ///< of HDF5's hash table: ten for each chunk, as its guide advises
  std::uint64_t HeldBytes = 0; ///< Bytes, and a chunk beside the cache with its encoded bytes
};

/// The size for boxes that are as wide as the last three axes but the first of them. The chunk has
/// as many axes as the shape.
ChunkCacheSize FindChunkCacheSize(const StoredArray::Numbers& shape,
  const StoredArray::Numbers& chunk, std::size_t valueSize, std::uint64_t cacheBytes);

} // namespace isosurface

#endif
