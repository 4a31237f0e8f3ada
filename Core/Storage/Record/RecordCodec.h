// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RecordCodec_h
#define isosurface_RecordCodec_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Record/BlockCompression.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/DecodedBlock.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

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

/// The predictor that gives the smallest segments, or nearly so, at a decoding speed that suits the
/// codec (Documentation/dev/compression.md). The coarsest level has no coarser one to predict from.
SamplePredictor ChoosePredictor(SegmentCodec codec, ValueType type, bool isCoarsest);

/**
 * Compresses a filled record in place and seals its segments, variable by variable, from the
 * coarsest level on. `layout` is that of the uncompressed segments before the call, and that of
 * the stored ones after it. The record's memory keeps its size; its padding, after layout.Size, is
 * zero.
 *
 * A segment that takes more than 15/16 of its samples' bytes when compressed is stored
 * uncompressed. Memory: twice the largest segment, kept for each thread. The bytes depend on the
 * arguments alone.
 */
void EncodeRecord(const BlockCompression& compression, const BlockGrid& grid, std::int64_t block,
  const std::vector<ValueType>& types, BlockRecordLayout& layout, Buffer<std::uint8_t>& record);

/**
 * Decodes one variable of a block at a level. segments[n] is the stored segment of level L - 1 - n
 * with its header, stored[n] the number of bytes after the header, for the levels from the coarsest
 * to `level`; CheckSegment() has found them intact.
 *
 * Errors name the place, not the file: Unsupported for an unknown codec or predictor, Corrupt for
 * bytes that do not decode to the segment's number of samples. Memory: the block and, kept for each
 * thread, twice its bytes.
 */
Result<std::shared_ptr<DecodedBlock>> DecodeLevel(const BlockGrid& grid, std::int64_t block,
  std::uint32_t variable, int level, ValueType type,
  const std::vector<const std::uint8_t*>& segments, const std::vector<std::uint32_t>& stored);

} // namespace isosurface

#endif
