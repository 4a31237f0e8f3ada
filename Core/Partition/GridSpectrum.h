// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridSpectrum_h
#define isosurface_GridSpectrum_h

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Partition/WorkloadSpectrum.h"
#include "Volume/BlockGrid.h"
#include "Volume/GridGeometry.h"
#include "Volume/SampleView.h"
#include "Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The spectrum of a grid whose samples are in memory, in pieces, on one rank or spread over
 * several: FindRanges(), then Count(). Each cell of the grid is in the Box of one piece of one
 * rank. The result is the same however the grid is cut. Its active blocks are of 32 cells a side,
 * counted from the grid's first vertex, its bytes those of their samples.
 *
 * Cost: two passes over the samples, on all threads; memory 16 bytes a block of the grid.
 */
class GridSpectrum
{
public:
  static constexpr int BlockSize = 32;

  /// The pieces are in the grid's coordinates; their samples must outlive this object.
  GridSpectrum(
    const GridGeometry& grid, ValueType type, std::vector<SampleView> pieces, int threads);

  /// Collective. Finds the value range of every block. Errors: Aborted.
  Status FindRanges(Communicator& ranks, const Progress& progress = {});

  /// Of the finite values of all ranks; once FindRanges() has found it.
  const KeyRange& GetFiniteRange() const { return this->FiniteRange; }

  /// Collective. The spectrum in bins that cover the finite range; equal on all ranks. Errors:
  /// Aborted.
  Result<WorkloadSpectrum> Count(
    Communicator& ranks, const SpectrumBins& bins, const Progress& progress = {}) const;

private:
  /// The part of a block that a piece has.
  struct Part
  {
    std::size_t Piece;
    std::int64_t Block;
    VertexBox Box;
  };
  struct Counted;

  Counted MakeCounted(const SpectrumBins& bins) const;
  void CountPart(const Part& part, Counted& counted) const;

  GridGeometry Grid;
  ValueType Type;
  BlockGrid Blocks;
  std::vector<SampleView> Pieces;
  std::vector<Part> Parts;
  int Threads;
  std::vector<KeyRange> Ranges; ///< per block
  KeyRange FiniteRange;
};

} // namespace isosurface

#endif
