// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexDirectory_h
#define isosurface_EdgeIndexDirectory_h

#include "Base/Status.h"
#include "EdgeIndex/BlockRecordFormat.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Where in a file the record of a block is.
struct EdgeIndexEntry
{
  std::uint64_t Offset = 0;
  std::uint64_t Size = 0;
  EdgeIndexBlock Block;
};

/**
 * What follows the records of a complete file, so that one can be found without reading the others:
 *
 *   0                     1 byte     where a record would have its size
 *   number of records     number
 *   for each, in the order of the file:
 *     size                number     of the whole record
 *     block               EdgeIndexBlock, as in the record
 *   checksum              8 bytes    XXH3 of all from the 0 on; seed: the header's checksum
 *
 *   trailer               32 bytes, the last ones of the file:
 *     0  offset of the directory's 0 (u64)      8  its size, checksum included (u64)
 *    16  XXH3 of these 16 bytes; seed: the header's checksum (u64)
 *    24  "EIXend.\n"
 */
struct EdgeIndexDirectory
{
  static constexpr std::size_t TrailerSize = 32;

  /// Appends the directory and the trailer. headerBytes: the header as it stands in the file.
  static void Append(const std::vector<EdgeIndexEntry>& entries,
    const std::vector<std::uint8_t>& headerBytes, std::vector<std::uint8_t>& bytes);

  /// Where the directory begins, by the trailer; 0 if that is none, or not of this file.
  static std::uint64_t ParseTrailer(const std::uint8_t* trailer,
    const std::vector<std::uint8_t>& headerBytes, std::uint64_t fileSize);

  /// The entries that `bytes`, a whole directory at this offset, has. Errors: Corrupt.
  static Result<std::vector<EdgeIndexEntry>> Parse(const EdgeIndexHeader& header,
    const std::vector<std::uint8_t>& headerBytes, const std::vector<std::uint8_t>& bytes,
    std::uint64_t offset);
};

} // namespace isosurface

#endif
