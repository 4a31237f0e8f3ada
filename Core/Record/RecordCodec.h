// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RecordCodec_h
#define isosurface_RecordCodec_h

#include "Base/Buffer.h"
#include "Base/Status.h"
#include "Record/BlockCompression.h"
#include "Record/BlockRecord.h"
#include "Record/DecodedBlock.h"
#include "Volume/BlockGrid.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The filter with which segments of a type become smallest, or nearly so, at a decoding speed that
 * suits the codec. Measured: Documentation/dev/compression.md.
 */
SegmentFilter ChooseFilter(SegmentCodec codec, ValueType type);

/**
 * Compresses a filled record in place and seals its segments, variable by variable, from the
 * coarsest level on. `layout` says where the samples are, one segment after another as they are;
 * afterwards where the stored segments are. The record's memory keeps its size; its padding
 * behind layout.Size is zero.
 *
 * A segment whose code takes more than 15/16 of its samples' bytes is stored as it is. Memory:
 * twice the largest segment, kept for each thread. The bytes depend on the arguments alone.
 */
void EncodeRecord(const BlockCompression& compression, const BlockGrid& grid, std::int64_t block,
  const std::vector<ValueType>& types, BlockRecordLayout& layout, Buffer<std::uint8_t>& record);

/**
 * The samples of one variable of a block at a level, from the stored segments of the levels from
 * the coarsest to `level`: segments[n] is that of level L - 1 - n, with `stored[n]` bytes behind
 * its header, as CheckSegment() has found them intact.
 *
 * Errors name the place, not the file: Unsupported for codecs and filters that are not known,
 * Corrupt for bytes that are not the code of as many samples as the segment has. Memory: the block
 * and, kept for each thread, twice its bytes.
 */
Result<std::shared_ptr<DecodedBlock>> DecodeLevel(const BlockGrid& grid, std::int64_t block,
  std::uint32_t variable, int level, ValueType type,
  const std::vector<const std::uint8_t*>& segments, const std::vector<std::uint32_t>& stored);

} // namespace isosurface

#endif
