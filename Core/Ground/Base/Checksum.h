// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Checksum_h
#define isosurface_Checksum_h

#include <cstddef>
#include <cstdint>
#include <string>

namespace isosurface
{

/**
 * Computes the 64-bit XXH3 hash of bytes. The seed is the place of the bytes (a page number, a
 * block index): bytes that were written to a wrong place do not match their checksum there.
 */
std::uint64_t ComputeChecksum(const void* bytes, std::size_t size, std::uint64_t seed = 0);

/// A 64-bit checksum as 16 hexadecimal digits.
std::string FormatChecksum(std::uint64_t checksum);

/// Reads what FormatChecksum wrote, from 16 characters; false if one is no such digit.
bool ParseChecksum(const char* digits, std::uint64_t& checksum);

} // namespace isosurface

#endif
