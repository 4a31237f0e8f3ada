// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexDirectory_h
#define isosurface_EdgeIndexDirectory_h

#include "Coding/EdgeIndex/BlockRecordFormat.h"
#include "Ground/Base/Status.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The place of a record in a file.
struct EdgeIndexEntry
{
  std::uint64_t Offset = 0;
  std::uint64_t Size = 0;
  EdgeIndexBlock Block;
};

/**
 * The directory and the trailer, which follow the records of a complete file:
 *
 *   0                   1 byte    where a record would have its size
 *   number of records   varint
 *   for each record, in the order of the file:
 *     size              varint    of the whole record
 *     block             EdgeIndexBlock, as in the record
 *   checksum            8 bytes   XXH3 of all from the 0 on; seed: the checksum of the header
 *
 *   the last 32 bytes of the file:
 *     0  8  offset of the directory
 *     8  8  size of the directory, including its checksum
 *    16  8  XXH3 of these 16 bytes, same seed
 *    24  8  "EIXend.\n"
 */
struct EdgeIndexDirectory
{
  static constexpr std::size_t TrailerSize = 32;

  /// Appends the directory and the trailer. headerBytes: the header as in the file.
  static void Append(const std::vector<EdgeIndexEntry>& entries,
    const std::vector<std::uint8_t>& headerBytes, std::vector<std::uint8_t>& bytes);

  /// The offset of the directory; 0 if the 32 bytes are not a trailer of this file.
  static std::uint64_t ParseTrailer(const std::uint8_t* trailer,
    const std::vector<std::uint8_t>& headerBytes, std::uint64_t fileSize);

  /// The entries of a directory: bytes from its offset to the trailer. Errors: Corrupt.
  static Result<std::vector<EdgeIndexEntry>> Parse(const EdgeIndexHeader& header,
    const std::vector<std::uint8_t>& headerBytes, const std::vector<std::uint8_t>& bytes,
    std::uint64_t offset);
};

} // namespace isosurface

#endif
