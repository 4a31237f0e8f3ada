// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Checksum.h"

#include <xxhash.h>

namespace isosurface
{

std::uint64_t ComputeChecksum(const void* bytes, std::size_t size, std::uint64_t seed)
{
  return XXH3_64bits_withSeed(bytes, size, seed);
}

std::string FormatChecksum(std::uint64_t checksum)
{
  std::string text(16, '0');
  for (std::size_t digit = 16; digit-- > 0; checksum >>= 4)
  {
    text[digit] = "0123456789abcdef"[checksum & 15];
  }
  return text;
}

} // namespace isosurface
