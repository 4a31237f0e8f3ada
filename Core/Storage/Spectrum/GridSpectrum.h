// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridSpectrum_h
#define isosurface_GridSpectrum_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Spectrum/BlockMeasure.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * Computes the spectrum of a grid in memory, in pieces, on one or several ranks: call FindRanges(),
 * then Count(). Each cell of the grid is in the Box of one piece of one rank. The result does not
 * depend on the pieces. The blocks of the spectrum have 32 cells a side, counted from the grid's
 * first vertex, and the bytes of their samples.
 *
 * Cost: two passes over the samples, on `threads` threads. Memory: 16 bytes a block of the grid.
 */
class GridSpectrum
{
public:
  static constexpr int BlockSize = 32;

  /// The pieces are in coordinates of the grid. Their samples must outlive this object.
  GridSpectrum(
    const GridGeometry& grid, ValueType type, std::vector<SampleView> pieces, int threads)
    : GridSpectrum(MeasuredGrid{ grid }, type, std::move(pieces), threads)
  {
  }
  GridSpectrum(
    const MeasuredGrid& grid, ValueType type, std::vector<SampleView> pieces, int threads);

  /// Collective. Finds the value range of every block. Errors of one rank are errors of all:
  /// Aborted, OutOfMemory.
  Status FindRanges(Communicator& ranks, const Progress& progress = {});

  /// The range of the finite values of all ranks. Call FindRanges() first.
  const KeyRange& GetFiniteRange() const { return this->FiniteRange; }

  /// Collective. Computes the spectrum in bins that cover the finite range. The result is the same
  /// on all ranks. Errors: as above.
  Result<WorkloadSpectrum> Count(
    Communicator& ranks, const SpectrumBins& bins, const Progress& progress = {}) const;

private:
  /// The intersection of a block and a piece.
  struct Overlap
  {
    std::size_t Piece;
    std::int64_t Block;
    VertexBox Box;
  };
  struct Counted;

  void FindOverlaps();
  /// The ranges of this rank's samples, by block.
  Status FindOwnRanges(const Progress& progress);
  /// Counts this rank's samples: the sums of all threads in the first of `counted`.
  Status CountOwn(
    const SpectrumBins& bins, const Progress& progress, std::vector<Counted>& counted) const;
  /// The active blocks and their bytes: from the ranges of all ranks.
  void SetActivity(const SpectrumBins& bins, WorkloadSpectrum& spectrum) const;
  void CountOverlap(const Overlap& part, Counted& counted) const;

  MeasuredGrid Grid;
  ValueType Type;
  BlockGrid Blocks;
  std::vector<SampleView> Pieces;
  std::vector<Overlap> Overlaps;
  int Threads;
  std::vector<KeyRange> Ranges; ///< per block; of this rank, then of all
  KeyRange FiniteRange;
};

} // namespace isosurface

#endif
