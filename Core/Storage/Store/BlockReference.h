// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockReference_h
#define isosurface_BlockReference_h

#include "Ground/Volume/BlockGrid.h"

#include <cstdint>

namespace isosurface
{

/// Where a block is stored: it is number Ordinal of a store. Block is its index in the BlockGrid of
/// the levels that it has.
struct BlockReference
{
  std::int64_t Block = 0;
  std::uint32_t Store = 0;
  std::uint32_t Ordinal = 0;
  std::uint32_t Part = 0;    ///< StoredLevel::Part
  std::uint32_t Replica = 0; ///< of the store, which is read first; all have the same bytes

  /// Whether both are the same block, of any replica.
  bool operator==(const BlockReference& other) const
  {
    return this->Block == other.Block && this->Store == other.Store &&
      this->Ordinal == other.Ordinal && this->Part == other.Part;
  }
};

/**
 * Where a level of a volume is stored: in the records of the volume's own blocks, or in those of an
 * overview's, which are blocks of a coarser grid. Grid->GetVertices(block, Level) are the vertices
 * of such a block in the coordinates of the volume's level, that is, level-0 coordinates / 2^level.
 */
struct StoredLevel
{
  std::uint32_t Part = 0;          ///< 0 is the volume itself, n the n-th overview
  int Level = 0;                   ///< of the records there
  const BlockGrid* Grid = nullptr; ///< the blocks there; belongs to the volume
};

} // namespace isosurface

#endif
