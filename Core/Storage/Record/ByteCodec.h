// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ByteCodec_h
#define isosurface_ByteCodec_h

#include "Storage/Record/BlockCompression.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// Compresses `size` bytes into at most `capacity`; returns the number of bytes written, 0 if they
/// do not fit. The result depends on the arguments and the version of the codec's library alone:
/// the codec's state, kept for each thread, is reset in each call.
std::size_t CompressBytes(SegmentCodec codec, int level, const std::uint8_t* from, std::size_t size,
  std::uint8_t* to, std::size_t capacity);

/// Decompresses `stored` bytes into exactly `size`; false if they do not decompress to `size`
/// bytes. Reads and writes within these bounds whatever the bytes are.
bool DecompressBytes(SegmentCodec codec, const std::uint8_t* from, std::size_t stored,
  std::uint8_t* to, std::size_t size);

} // namespace isosurface

#endif
