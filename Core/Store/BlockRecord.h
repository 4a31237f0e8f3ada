// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRecord_h
#define isosurface_BlockRecord_h

#include "Base/Status.h"
#include "Store/BlockCache.h"
#include "Store/BlockSegment.h"
#include "Volume/BlockGrid.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The bytes of a block in a store's file `blocks`. Records begin at multiples of 4096 bytes; what
 * follows the last segment up to the next such multiple is zero. Little-endian throughout.
 *
 *     record                                     segment
 *     +---------------------------------+        +----+--------------------------------------+
 *     | array 0: segment, level L - 1   |        |  0 | checksum                   (uint64)  |
 *     |          ...                    |        |  8 | bytes stored               (uint32)  |
 *     |          segment, level 0       |        | 12 | codec: 0 as it is          (uint8)   |
 *     | array 1: segment, level L - 1   |        | 13 | filter: 0 none             (uint8)   |
 *     |          ...                    |        | 14 | 0                          (uint16)  |
 *     | zeros                           |        | 16 | stored bytes: the samples of the     |
 *     +---------------------------------+        |    | level as BlockSegment lists them     |
 *                                                +----+--------------------------------------+
 *     checksum: XXH3-64 of the segment from byte 8 on, seeded by XXH3-64 of block index (uint64),
 *     array (uint32), level (uint32): a segment in a wrong place is recognised like a damaged one.
 */
struct BlockRecord
{
  static constexpr std::uint64_t Alignment = 4096;
  static constexpr std::uint64_t SegmentHeaderSize = 16;

  static std::uint64_t AlignUp(std::uint64_t size)
  {
    return (size + Alignment - 1) / Alignment * Alignment;
  }
};

/// Where a segment belongs.
struct SegmentPlace
{
  std::int64_t Block;
  std::uint32_t Array;
  std::uint32_t Level;
};

/// Writes the header before the `stored` bytes that already stand at segment + SegmentHeaderSize.
void SealSegment(std::uint8_t* segment, std::uint32_t stored, const SegmentPlace& place);

/// Checks a segment of SegmentHeaderSize + stored bytes. The message (Corrupt, Unsupported) names
/// the place, not the file.
Status CheckSegment(const std::uint8_t* segment, std::uint32_t stored, const SegmentPlace& place);

/**
 * Puts the samples of a level together. segments[n] is the payload of level L - 1 - n, for the
 * levels from the coarsest to `level`.
 */
std::shared_ptr<DecodedBlock> AssembleLevel(const BlockGrid& grid, std::int64_t block, int level,
  ValueType type, const std::vector<const std::uint8_t*>& segments);

/// Where the segments of a record are if every one is stored as it is.
struct BlockRecordLayout
{
  BlockRecordLayout(const BlockGrid& grid, std::int64_t block, const std::vector<ValueType>& types);

  /// Per segment in the order of the record: bytes from the record's begin to its header.
  std::vector<std::uint64_t> Offsets;
  /// Per segment: the bytes stored, without the header.
  std::vector<std::uint32_t> Lengths;
  std::uint64_t Samples = 0; ///< of all segments
  std::uint64_t Size = 0;    ///< of the record, without padding
};

} // namespace isosurface

#endif
