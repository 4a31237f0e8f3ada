// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PackedCounts_h
#define isosurface_PackedCounts_h

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * A curve of counts in few bytes: the differences from one count to the next (the first one's from
 * 0), modulo 2^64, as signed numbers d in zigzag order (0, -1, 1, -2, ... are 0, 1, 2, 3, ...),
 * each in groups of 7 bits, least significant first, the highest bit set on all bytes but the last
 * one (LEB128). A difference of 0 is followed by how many more zeros follow it, in the same groups.
 */
void AppendPackedCounts(const std::vector<std::uint64_t>& counts, std::vector<std::uint8_t>& bytes);

/// Reads counts.size() counts from bytes + position on, and moves on; false if there are not so
/// many, or a number does not fit.
bool TakePackedCounts(const std::uint8_t* bytes, std::size_t size, std::size_t& position,
  std::vector<std::uint64_t>& counts);

} // namespace isosurface

#endif
