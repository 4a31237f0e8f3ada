// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockWorkload_h
#define isosurface_BlockWorkload_h

#include "Partition/VertexChanges.h"
#include "Partition/WorkloadSpectrum.h"
#include "Volume/SampleView.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Counts the marching-cubes triangles and the active cells of blocks for all isovalues at once,
 * exactly: a cell's number of triangles changes only where the isovalue passes one of its eight
 * corner values. The changes of the cells around a vertex are summed up (VertexChanges) before they
 * are noted in the bin of its value; most sums are 0 where values are smooth. Running sums over the
 * bins give the spectrum. NaN is outside for every isovalue.
 *
 * Source: X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive datasets on commodity
 * off-the-shelf clusters", 2009, section 4.1.1, after C. Bajaj, V. Pascucci, D. Schikore, "The
 * contour spectrum", 1997.
 *
 * Cost: 2 ns a cell where values are smooth, 4 in noise (vectors of 32 bytes); memory 4 bytes a
 * vertex of the largest box and 16 a bin. One object serves one thread at a time.
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
  struct Change
  {
    std::int64_t Triangles = 0;
    std::int64_t Cells = 0;
  };

  void AddChanges(std::size_t begin, std::size_t end);
  void Unpack();

  SpectrumBins Bins;
  VertexChanges Vertices;      ///< their values: how many edges are <= them
  std::vector<Change> Changes; ///< per number of edges
  /// The latest changes, per number of edges: triangles + cells * 2^32, of so few vertices that the
  /// triangles fill less than half of it.
  std::vector<std::int64_t> PackedChanges;
  std::size_t PackedVertices = 0;
};

} // namespace isosurface

#endif
