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

/// What a block's code holds beside the signs.
enum class BlockCoding : std::uint8_t
{
  Values = 0,    ///< lossless or quantized values at the relevant vertices
  Crossings = 1, ///< where on the crossed edges the points are
};

/**
 * The record of one block at one isovalue; in bytes:
 *
 *   size of the rest      number
 *   isovalue              number     its place in the header
 *   low vertex            3 numbers
 *   cells                 3 bytes    1 to 64 each
 *   lattice coordinates   3 signed numbers
 *   coding                1 byte     BlockCoding; + 2 if a crossing is not a number
 *   scale                 signed number (values only)
 *   code                  bytes
 *   checksum              4 bytes    the lower half of XXH3 of all from the isovalue on
 *
 * A number is in groups of 7 bits, lowest first, of which all but the last have the top bit set; a
 * signed one n is stored as 2 n, or -2 n - 1 if negative.
 */
struct EdgeIndexRecord
{
  std::size_t Isovalue = 0;
  VertexBox Vertices;
  Index3 Lattice{};
  BlockCoding Coding = BlockCoding::Values;
  bool HasMissing = false; ///< some crossings are not numbers
  int Scale = 0;
  const std::uint8_t* Code = nullptr;
  std::size_t CodeSize = 0;

  void Append(std::vector<std::uint8_t>& bytes) const;

  /**
   * Reads the record at the begin of `bytes`; `used` becomes its size. Errors: Corrupt.
   * The code is not copied.
   */
  static Result<EdgeIndexRecord> Parse(const EdgeIndexHeader& header, const std::uint8_t* bytes,
    std::size_t size, std::size_t& used);
};

} // namespace isosurface

#endif
