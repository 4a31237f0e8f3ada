// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Checksum.h"

#include <xxhash.h>

namespace isosurface
{

std::uint64_t ComputeChecksum(const void* bytes, std::size_t size, std::uint64_t seed)
{
  return XXH3_64bits_withSeed(bytes, size, seed);
}

} // namespace isosurface
