// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRecord_h
#define isosurface_BlockRecord_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Record/BlockCompression.h"
#include "Storage/Record/BlockSegment.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Record/SegmentFilter.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/**
 * The bytes of a block in a store's file `blocks`. Records begin at multiples of 4096 bytes; zeros
 * fill the file from a record's last segment to the next such multiple. Little-endian throughout.
 *
 *     record                                     segment
 *     +------------------------------------+     +----+-----------------------------------------+
 *     | variable 0: segment of level L - 1 |     |  0 | checksum                       (uint64) |
 *     |             ...                    |     |  8 | m, the bytes stored            (uint32) |
 *     |             segment of level 0     |     | 12 | codec: SegmentCodec             (uint8) |
 *     | variable 1: segment of level L - 1 |     | 13 | predictor: SamplePredictor      (uint8) |
 *     |             ...                    |     | 14 | 0                              (uint16) |
 *     |             segment of level 0     |     | 16 | m bytes: the samples that BlockSegment  |
 *     | zeros                              |     |    | lists, filtered (SegmentFilter.h) and   |
 *     +------------------------------------+     |    | compressed; with codec 0 as they are    |
 *                                                +----+-----------------------------------------+
 *
 * checksum: XXH3-64 of the segment from byte 8 on, with the XXH3-64 of block index (uint64),
 * variable (uint32) and level (uint32) as its seed, so a segment in a wrong place is detected like
 * a damaged one. Variables: the components of all arrays (ArrayVariables), each stored as a scalar
 * grid of its own, so that one component is read without the others.
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

/// How the stored bytes of a segment are decoded.
struct SegmentCoding
{
  SegmentCodec Codec = SegmentCodec::None;
  SamplePredictor Predictor = SamplePredictor::None;
};

/// Writes the segment's header. The `stored` bytes must already be at segment + SegmentHeaderSize.
void SealSegment(std::uint8_t* segment, std::uint32_t stored, const SegmentCoding& coding,
  const SegmentPlace& place);

/// The coding that a segment's header states, or nothing if this version does not know it.
std::optional<SegmentCoding> LoadSegmentCoding(const std::uint8_t* segment);

/// Checks the checksum and the length of a segment of SegmentHeaderSize + stored bytes. The message
/// of the error (Corrupt) names the place, not the file.
Status CheckSegment(const std::uint8_t* segment, std::uint32_t stored, const SegmentPlace& place);

/// Assembles the samples of a level from decoded segments: segments[n] are the samples of level
/// L - 1 - n, for the levels from the coarsest to `level`. They need not be aligned.
std::shared_ptr<DecodedBlock> AssembleLevel(const BlockGrid& grid, std::int64_t block, int level,
  ValueType type, const std::vector<const std::uint8_t*>& segments);

/// Computes the magnitudes of an array's tuples from all of its components (at least one) at one
/// level.
std::shared_ptr<DecodedBlock> MakeMagnitudeBlock(const DecodedBlocks& components);

/// Where the segments of a record are. A new layout is that of uncompressed segments.
struct BlockRecordLayout
{
  /// `types`: of the components, in the order of the record.
  BlockRecordLayout(const BlockGrid& grid, std::int64_t block, const std::vector<ValueType>& types);

  /// Per segment, in the order of the record: bytes from the record's start to the header.
  std::vector<std::uint64_t> Offsets;
  /// Per segment: bytes stored, without the header.
  std::vector<std::uint32_t> Lengths;
  std::uint64_t Samples = 0; ///< of all segments
  std::uint64_t Size = 0;    ///< of the record, without padding
};

} // namespace isosurface

#endif
