// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRecordFormat_h
#define isosurface_BlockRecordFormat_h

#include "Base/Status.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

class NumberReader;

/// What a block's code holds beside the signs.
enum class BlockCoding : std::uint8_t
{
  Values = 0,    ///< lossless or quantized values at the relevant vertices
  Crossings = 1, ///< where on the crossed edges the points are
};

/**
 * What a record says of its block before the code. In bytes:
 *
 *   isovalue              number     its place in the header
 *   low vertex            3 numbers  in the grid of the level
 *   cells                 3 bytes    1 to 64 each
 *   lattice coordinates   3 signed numbers
 *   points                number     crossed edges of the block, shared faces included
 *   coding                1 byte     BlockCoding; + 2 if a crossing is not a number; + 4 if
 *                                    this is a block of the preview
 *
 * Numbers are those of CodedNumbers.h.
 */
struct EdgeIndexBlock
{
  std::size_t Isovalue = 0;
  VertexBox Vertices;
  Index3 Lattice{};
  std::uint64_t NumberOfPoints = 0;
  BlockCoding Coding = BlockCoding::Values;
  bool HasMissing = false; ///< some crossings are not numbers
  bool IsPreview = false;  ///< of the coarse level EdgeIndexHeader::PreviewLevel

  void Append(std::vector<std::uint8_t>& bytes) const;

  /// Errors: Corrupt. `header` is that of the stream.
  static Result<EdgeIndexBlock> Parse(const EdgeIndexHeader& header, NumberReader& reader);

  bool operator==(const EdgeIndexBlock& other) const;
};

/**
 * The record of one block at one isovalue; in bytes:
 *
 *   size of the rest      number     never 0
 *   block                 EdgeIndexBlock
 *   scale                 signed number (values only)
 *   code                  bytes
 *   checksum              4 bytes    the lower half of XXH3 of all from the block on
 */
struct EdgeIndexRecord
{
  EdgeIndexBlock Block;
  int Scale = 0;
  const std::uint8_t* Code = nullptr;
  std::size_t CodeSize = 0;

  void Append(std::vector<std::uint8_t>& bytes) const;

  /**
   * Reads the record at the begin of `bytes`; `used` becomes its size. Errors: Corrupt.
   * The code is not copied.
   */
  static Result<EdgeIndexRecord> Parse(
    const EdgeIndexHeader& header, const std::uint8_t* bytes, std::size_t size, std::size_t& used);

  /**
   * The size of the record at the begin of `bytes` as it says itself; 0 if it is not a size yet
   * (fewer than 10 bytes are there), or never will be.
   */
  static std::uint64_t ReadSize(const std::uint8_t* bytes, std::size_t size);
};

} // namespace isosurface

#endif
