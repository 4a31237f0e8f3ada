// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Checksum_h
#define isosurface_Checksum_h

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * The 64-bit XXH3 hash of some bytes. The seed says where the bytes belong (a page number, a block
 * index), so that bytes of one place found in another are recognised as wrong, too.
 */
std::uint64_t ComputeChecksum(const void* bytes, std::size_t size, std::uint64_t seed = 0);

} // namespace isosurface

#endif
