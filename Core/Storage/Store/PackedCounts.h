// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PackedCounts_h
#define isosurface_PackedCounts_h

#include "Ground/Base/Coding.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Appends a curve of counts in few bytes: the differences from one count to the next (of the first
 * one from 0), modulo 2^64, as signed varints (Coding.h). After a difference of 0 follows a varint:
 * the number of further zeros, which are omitted.
 */
void AppendPackedCounts(const std::vector<std::uint64_t>& counts, std::vector<std::uint8_t>& bytes);

/// Reads counts.size() counts; false if there are fewer, or a number does not fit.
bool ReadPackedCounts(ByteReader& reader, std::vector<std::uint64_t>& counts);

} // namespace isosurface

#endif
