// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrCodec_h
#define isosurface_ZarrCodec_h

#include "Ground/Base/Status.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What turned the bytes of a chunk into others.
enum class ZarrCodec : std::uint8_t
{
  Inflate, ///< gzip or zlib
  Zstd,
  Lz4,   ///< of numcodecs: the number of bytes, then a block of LZ4
  Blosc, ///< with any of its compressors
  Crc32c ///< a checksum of four bytes at the end
};

/// The codec of that name in the metadata of Zarr or N5; nothing if it is not supported.
std::optional<ZarrCodec> FindZarrCodec(const std::string& name);
/// Loads the module of a codec, if it has one. Error: a sentence without a file.
Status LoadZarrCodec(ZarrCodec codec);

/// CRC-32C, the polynomial of Castagnoli (RFC 3720, appendix B.4).
std::uint32_t ComputeCrc32c(const std::uint8_t* bytes, std::size_t size);

/**
 * Undoes codecs, the last one first, of which one at most compresses. The result must have exactly
 * `size` bytes, written to `to`. False if the bytes are damaged, or have another size. Memory: a copy
 * of the result if a checksum was compressed with it.
 */
bool DecodeZarr(const std::vector<ZarrCodec>& codecs, const std::uint8_t* from,
  std::size_t fromSize, std::uint8_t* to, std::size_t size);

} // namespace isosurface

#endif
