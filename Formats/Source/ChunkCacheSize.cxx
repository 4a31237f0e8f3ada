// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/ChunkCacheSize.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{

ChunkCacheSize FindChunkCacheSize(const StoredArray::Numbers& shape,
  const StoredArray::Numbers& chunk, std::size_t valueSize, std::uint64_t cacheBytes)
{
  constexpr double mostSlots = 1048573;
  constexpr double mostBytes = 1e15;
  double chunkBytes = static_cast<double>(valueSize);
  double slabChunks = 1;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    const auto size = static_cast<double>(std::max<std::int64_t>(1, chunk[axis]));
    chunkBytes *= size;
    const bool isWithinSlab = axis + 2 >= chunk.size();
    slabChunks *= isWithinSlab ? std::ceil(static_cast<double>(shape[axis]) / size) : 1;
  }
  ChunkCacheSize cache;
  cache.ChunkBytes = chunkBytes;
  const double bytes = std::min(static_cast<double>(cacheBytes), chunkBytes * (slabChunks + 1));
  cache.Bytes = static_cast<std::size_t>(bytes);
  cache.Slots =
    static_cast<std::size_t>(std::min(10 * (std::floor(bytes / chunkBytes) + 1) + 1, mostSlots));
  cache.HeldBytes = cache.Bytes + static_cast<std::uint64_t>(std::min(2 * chunkBytes, mostBytes));
  return cache;
}

} // namespace isosurface
