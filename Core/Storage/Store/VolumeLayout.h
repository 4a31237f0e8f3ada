// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeLayout_h
#define isosurface_VolumeLayout_h

#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/GridPlace.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// Where a block is stored: it is number Ordinal of a store. Block is its index in the BlockGrid of
/// the levels that it has.
struct BlockReference
{
  std::int64_t Block = 0;
  std::uint32_t Store = 0;
  std::uint32_t Ordinal = 0;
  std::uint32_t Overview = 0; ///< StoredLevel::Overview
  std::uint32_t Replica = 0;  ///< of the store, which is read first; all have the same bytes

  /// Whether both are the same block, of any replica.
  bool operator==(const BlockReference& other) const
  {
    return this->Block == other.Block && this->Store == other.Store &&
      this->Ordinal == other.Ordinal && this->Overview == other.Overview;
  }
};

/**
 * Where a level of a volume is stored: in the records of the volume's own blocks, or in those of an
 * overview's, which are blocks of a coarser grid. Grid->GetVertices(block, Level) are the vertices
 * of such a block in the coordinates of the volume's level, that is, level-0 coordinates / 2^level.
 */
struct StoredLevel
{
  std::uint32_t Overview = 0;      ///< 0 is the volume itself, n the n-th overview
  int Level = 0;                   ///< of the records there
  const BlockGrid* Grid = nullptr; ///< the blocks there; belongs to the volume
};

/// The blocks of the volume itself, or of one of its overviews.
struct StoredGrid
{
  BlockedVolumeHeader Header;
  BlockGrid Grid;
  int FirstLevel = 0;                    ///< the finest level here, among those of the volume
  std::vector<std::uint64_t> Identities; ///< per time step: Dataset of its BlockCacheKey
};

/// What the header of a blocked volume tells: its grids, levels and variables. It does not change.
class VolumeLayout
{
public:
  /// `text`: that of the header's file. `found`: the grid there, if the one of `header` is another.
  VolumeLayout(std::string path, const std::string& text, BlockedVolumeHeader header,
    const GridGeometry& found);

  const std::string& GetPath() const { return this->Path; }
  /// The bytes of the header's file, and its last ones, which have the checksum of all others.
  std::uint64_t GetHeaderSize() const { return this->HeaderSize; }
  const std::string& GetHeaderEnd() const { return this->HeaderEnd; }
  const BlockedVolumeHeader& GetHeader() const { return this->StoredGrids.front().Header; }
  /// The grid of the header's file, whatever GridPlace has changed.
  const GridGeometry& GetFoundGrid() const { return this->FoundGrid; }
  /// Differs between volumes with different headers: other contents, another write (whose time
  /// steps are in other folders), another number of time steps, another place. It does not depend on
  /// the path.
  std::uint64_t GetFingerprint() const { return this->Fingerprint; }
  /// The components and magnitudes that can be contoured and read.
  const ArrayVariables& GetVariables() const { return this->Variables; }
  /// The volume's own blocks, which have its finest levels.
  const BlockGrid& GetBlockGrid() const { return this->StoredGrids.front().Grid; }

  /// The volume, then its overviews from the finest to the coarsest.
  const std::vector<StoredGrid>& GetStoredGrids() const { return this->StoredGrids; }
  /// Level l has every vertex whose coordinates are multiples of 2^l, wherever it is stored.
  int GetNumberOfLevels() const;
  /// `level` must be one of the volume's.
  StoredLevel FindLevel(int level) const;
  /// The finest level that is stored in the same blocks as this one; it has a spectrum.
  int GetSpectrumLevel(int level) const { return level - this->FindLevel(level).Level; }
  /// The lines of a level of a rectilinear grid, valid as long as this object; null of other grids.
  const GridLines* GetLines(int level) const
  {
    return this->Lines.empty() ? nullptr : &this->Lines[static_cast<std::size_t>(level)];
  }
  /// Whether the samples of a level are in the volume's source.
  bool IsInSource(const StoredLevel& stored) const
  {
    return stored.Overview == 0 && this->GetHeader().IsInPlace();
  }
  /// BlockCacheKey::Dataset of all that can be cached: blocks, and chunks of sources.
  std::vector<std::uint64_t> ListDatasets() const;
  BlockCacheKey MakeKey(std::int64_t block, std::size_t timeStep, std::size_t variable,
    const StoredLevel& stored) const;

private:
  /// `place`: the canonical path.
  void AddGrid(BlockedVolumeHeader header, const std::string& place);

  std::string Path;
  std::uint64_t HeaderSize;
  std::string HeaderEnd;
  GridGeometry FoundGrid;
  std::uint64_t Fingerprint;
  ArrayVariables Variables;
  std::vector<StoredGrid> StoredGrids;
  std::vector<GridLines> Lines; ///< per level, of a rectilinear grid
};

} // namespace isosurface

#endif
