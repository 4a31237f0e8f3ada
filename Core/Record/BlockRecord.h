// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRecord_h
#define isosurface_BlockRecord_h

#include "Base/Status.h"
#include "Record/BlockCompression.h"
#include "Record/BlockSegment.h"
#include "Record/DecodedBlock.h"
#include "Record/SegmentFilter.h"
#include "Volume/BlockGrid.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/**
 * The bytes of a block in a store's file `blocks`. Records begin at multiples of 4096 bytes; what
 * follows the last segment up to the next such multiple is zero. Little-endian throughout.
 *
 *     record                                     segment
 *     +---------------------------------+        +----+--------------------------------------+
 *     | variable 0: segment, level L - 1|        |  0 | checksum                   (uint64)  |
 *     |          ...                    |        |  8 | bytes stored               (uint32)  |
 *     |          segment, level 0       |        | 12 | codec: SegmentCodec        (uint8)   |
 *     | variable 1: segment, level L - 1|        | 13 | filter: SegmentFilter      (uint8)   |
 *     |          ...                    |        | 14 | 0                          (uint16)  |
 *     | zeros                           |        | 16 | stored bytes: the samples of the     |
 *     +---------------------------------+        |    | level as BlockSegment lists them,    |
 *                                                |    | filtered and compressed              |
 *                                                +----+--------------------------------------+
 *     checksum: XXH3-64 of the segment from byte 8 on, seeded by XXH3-64 of block index (uint64),
 *     variable (uint32), level (uint32): a segment in a wrong place is recognised like a damaged
 * one.
 *
 * Variables: the components of all arrays (ArrayVariables), each a scalar grid of its own, so that
 * one component is read without the others and compression sees like next to like.
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
  std::uint32_t Variable;
  std::uint32_t Level;
};

/// How the stored bytes of a segment give its samples.
struct SegmentCoding
{
  SegmentCodec Codec = SegmentCodec::None;
  SegmentFilter Filter;
};

/// Writes the header before the `stored` bytes that already stand at segment + SegmentHeaderSize.
void SealSegment(std::uint8_t* segment, std::uint32_t stored, const SegmentCoding& coding,
  const SegmentPlace& place);

/// What a segment's header says; nothing if this version does not know it.
std::optional<SegmentCoding> LoadSegmentCoding(const std::uint8_t* segment);

/// Checks a segment of SegmentHeaderSize + stored bytes against its checksum and length. The
/// message (Corrupt) names the place, not the file.
Status CheckSegment(const std::uint8_t* segment, std::uint32_t stored, const SegmentPlace& place);

/**
 * Puts the samples of a level together. segments[n] is the samples of the segment of level
 * L - 1 - n, at any address, for the levels from the coarsest to `level`.
 */
std::shared_ptr<DecodedBlock> AssembleLevel(const BlockGrid& grid, std::int64_t block, int level,
  ValueType type, const std::vector<const std::uint8_t*>& segments);

/// The magnitudes of an array's tuples, from all of its components at one level.
std::shared_ptr<DecodedBlock> MakeMagnitudeBlock(const DecodedBlocks& components);

/// Where the segments of a record are; when made, if every one is stored as it is.
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
