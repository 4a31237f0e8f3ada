// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSpectra_h
#define isosurface_BlockSpectra_h

#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The load of an isosurface on a store, or on all stores.
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
  /// The maximum of each member, not necessarily of the same store.
  IsosurfaceLoad GetMaximum(std::size_t bin) const;
};

/**
 * The spectrum of each block of a volume. Gives the loads of the stores for any distribution of the
 * blocks without writing the volume. The loads are exact.
 *
 * Memory: 4 bytes for each block and bin of the block's value range. Several threads may call Set()
 * for different blocks.
 */
class BlockSpectra
{
public:
  BlockSpectra(ValueType type, const SpectrumBins& bins, std::size_t blocks);

  /// `spectrum` must have the bins of this object; `range`: of the block's values; `bytes`: of its
  /// record.
  void Set(std::size_t block, const WorkloadSpectrum& spectrum, const KeyRange& range,
    std::uint64_t bytes);

  std::size_t GetNumberOfBlocks() const { return this->Blocks.size(); }
  const SpectrumBins& GetBins() const { return this->Bins; }
  std::uint64_t GetTriangles(std::size_t block, std::size_t bin) const;

  /**
   * A lower bound on the maximum triangles of a store, for any distribution of whole blocks: the
   * maximum of the mean, and for every n, of the triangles of the n + 1 smallest of the n * stores
   * + 1 largest blocks, since some store has n + 1 of these. Cost: sorting the bin's blocks.
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
