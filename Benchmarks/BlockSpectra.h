// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSpectra_h
#define isosurface_BlockSpectra_h

#include "Partition/WorkloadSpectrum.h"
#include "Volume/ValueKey.h"
#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// What an isosurface costs a store, or all of them.
struct IsosurfaceLoad
{
  std::uint64_t Triangles = 0;
  std::uint64_t ActiveBlocks = 0;
  std::uint64_t Bytes = 0; ///< of the active blocks
};

/// The loads of all stores at the isovalues of a spectrum.
struct StoreLoads
{
  SpectrumBins Bins;
  std::vector<std::vector<IsosurfaceLoad>> Stores; ///< [store][bin]

  IsosurfaceLoad GetTotal(std::size_t bin) const;
  /// The greatest of each kind, not necessarily of one store.
  IsosurfaceLoad GetMaximum(std::size_t bin) const;
};

/**
 * The spectrum of each block of a volume, from which the stores' loads follow for any distribution
 * of the blocks, without writing it. The same numbers as those of a volume that is written so.
 *
 * Memory: 4 bytes a block and bin of the block's own range of values. Set() may be called by
 * several threads for different blocks.
 */
class BlockSpectra
{
public:
  BlockSpectra(ValueType type, const SpectrumBins& bins, std::size_t blocks);

  /// `spectrum` has the bins of all; `range` are the block's values, `bytes` what its record takes.
  void Set(std::size_t block, const WorkloadSpectrum& spectrum, const KeyRange& range,
    std::uint64_t bytes);

  std::size_t GetNumberOfBlocks() const { return this->Blocks.size(); }
  const SpectrumBins& GetBins() const { return this->Bins; }
  std::uint64_t GetTriangles(std::size_t block, std::size_t bin) const;

  /**
   * No distribution of whole blocks over so many stores has a greatest number of triangles below
   * this (a real one may still not get there): that of the largest block; the mean, rounded up; and
   * for every n, since one of the stores has n + 1 of the n * stores + 1 largest blocks, the
   * triangles of the n + 1 smallest of these. Cost: sorting the bin's blocks.
   */
  std::uint64_t GetMaximumBound(std::size_t bin, std::uint32_t stores) const;

  /// blockStores[block] < stores. Cost: one visit of all counts; 24 bytes a store and bin.
  StoreLoads Distribute(const std::vector<std::uint32_t>& blockStores, std::uint32_t stores) const;

private:
  struct Block
  {
    std::uint32_t Begin = 0; ///< the bins [Begin, Begin + Triangles.size()) are active
    std::uint64_t Bytes = 0;
    std::vector<std::uint32_t> Triangles;
  };

  ValueType Type;
  SpectrumBins Bins;
  std::vector<Block> Blocks;
};

} // namespace isosurface

#endif
