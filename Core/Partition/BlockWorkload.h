// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockWorkload_h
#define isosurface_BlockWorkload_h

#include "Partition/WorkloadSpectrum.h"
#include "Volume/SampleView.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Counts the marching-cubes triangles and the active cells of blocks for all isovalues at once,
 * exactly: a cell's number of triangles changes only where the isovalue passes one of its eight
 * corner values, and then by what marching cubes has for the corners that were inside before and
 * after. These are found by comparing every corner with every other one, many cells at a time (no
 * sorting); the changes of the cells around a vertex are summed up before they are noted in the bin
 * of its value. Running sums over the bins give the spectrum. NaN is outside for every isovalue.
 *
 * Source: X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive datasets on commodity
 * off-the-shelf clusters", 2009, section 4.1.1, after C. Bajaj, V. Pascucci, D. Schikore, "The
 * contour spectrum", 1997.
 *
 * Cost: about 5 ns a cell (AVX-512; 8 without), runs of 256 equal cells less; memory 4 bytes a
 * vertex of the largest box and 32 KiB. One object serves one thread at a time.
 */
class BlockWorkload
{
public:
  explicit BlockWorkload(const SpectrumBins& bins);

  /// Adds the cells of the samples' Box (of one or more blocks, one after another).
  void Count(const SampleView& samples);

  /// Adds what was counted since the last call to a spectrum of the same bins, and forgets it.
  void MoveTo(WorkloadSpectrum& spectrum);

private:
  static constexpr std::int64_t CellsAtOnce = 256;

  /// Per corner and cell: the corners (one bit each) that are inside until this one goes outside.
  using CornerMasks = std::array<std::array<std::int16_t, CellsAtOnce>, 8>;
  struct Change
  {
    std::int64_t Triangles = 0;
    std::int64_t Cells = 0;
  };

  template <typename T>
  void FindBins(const SampleView& samples);
  void CountSlice(std::int64_t begin, std::int64_t columns, std::int64_t rows);
  static void FindMasks(const std::int16_t* base, std::int64_t cells, std::int64_t rowStride,
    std::int64_t sliceStride, CornerMasks& masks);
  void AddChanges(const CornerMasks& masks, std::int64_t row, std::int64_t cells,
    std::int64_t rowStride, std::int64_t sliceStride);

  SpectrumBins Bins;
  std::vector<std::int16_t> EdgeCounts;    ///< per vertex: how many edges are <= its value
  std::vector<std::int16_t> VertexChanges; ///< per vertex: of all cells when it goes outside
  std::vector<Change> Changes;             ///< per number of edges
};

} // namespace isosurface

#endif
