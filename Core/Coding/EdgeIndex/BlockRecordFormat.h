// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockRecordFormat_h
#define isosurface_BlockRecordFormat_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

class ByteReader;

/// What the code of a block holds besides the signs.
enum class CodedGeometry : std::uint8_t
{
  Values = 0,    ///< values at the ends of crossed edges
  Crossings = 1, ///< positions of points on crossed edges
};

/**
 * The description of a block, before its code in a record, and in the directory:
 *
 *   isovalue              varint            its index in the header
 *   low vertex            3 varints         in the grid (of the preview's level)
 *   cells                 3 bytes           1 to 64 each
 *   lattice coordinates   3 signed varints
 *   points                varint            crossed edges, including those on shared faces; 0 only of a
 *                                           closed surface, at a side of the grid. If islands are left out:
 *                                           the points of those that are kept
 *   coding                1 byte            CodedGeometry; + 2 if some crossing is not a number;
 *                                           + 4 if the block belongs to the preview;
 *                                           + 8 if some of its islands are left out
 *
 * Varints are those of Base/Coding.h, below 2^63.
 */
struct EdgeIndexBlock
{
  std::size_t Isovalue = 0;
  VertexBox Vertices;
  Index3 Lattice{};
  std::uint64_t NumberOfPoints = 0;
  CodedGeometry Coding = CodedGeometry::Values;
  bool HasMissing = false; ///< some crossings are NaN; only if crossings are coded
  bool IsPreview = false;  ///< at the level EdgeIndexHeader::PreviewLevel
  bool LacksIslands = false;

  void Append(std::vector<std::uint8_t>& bytes) const;

  /// Errors: Corrupt. `header` is that of the stream.
  static Result<EdgeIndexBlock> Parse(const EdgeIndexHeader& header, ByteReader& reader);

  bool operator==(const EdgeIndexBlock& other) const;
};

/**
 * The record of one block at one isovalue:
 *
 *   size of the rest   varint          never 0
 *   block              EdgeIndexBlock
 *   scale              signed varint   only if values are coded
 *   islands            varint          only if some are left out: how many the block's surface has alone; see
 *                                      FindBlockIslands for their order
 *   kept ones          bits            likewise: 1 if the island is kept, from the lowest bit of the first byte
 *                                      on, with zeros up to whole bytes
 *   code               bytes
 *   checksum           4 bytes         the lower half of XXH3 of all from the block on
 */
struct EdgeIndexRecord
{
  EdgeIndexBlock Block;
  int Scale = 0;                      ///< of heights, see ValueDomain::ToHeight
  std::vector<bool> AreKept;          ///< of the block's islands, if some are left out
  const std::uint8_t* Code = nullptr; ///< not owned
  std::size_t CodeSize = 0;

  void Append(std::vector<std::uint8_t>& bytes) const;

  /**
   * Reads the record at the start of `bytes`, which its Code then points into; `used` becomes its
   * size. Errors: Corrupt.
   */
  static Result<EdgeIndexRecord> Parse(
    const EdgeIndexHeader& header, const std::uint8_t* bytes, std::size_t size, std::size_t& used);

  /**
   * The size of the record that starts at `bytes`, as it says itself. 0 if `bytes` has too few
   * bytes to tell (10 are enough), or no valid size.
   */
  static std::uint64_t ReadSize(const std::uint8_t* bytes, std::size_t size);
};

} // namespace isosurface

#endif
