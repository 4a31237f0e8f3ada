// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockWorkload_h
#define isosurface_BlockWorkload_h

#include "Ground/Volume/SampleView.h"
#include "Storage/Spectrum/VertexChanges.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Counts the marching-cubes triangles and the active cells of blocks for all isovalues at once.
 * Exact: the number of triangles in a cell changes only where the isovalue passes the value of one
 * of its corners. VertexChanges sums the changes of the cells around each vertex; most sums are 0
 * where values are smooth. They are added to the bin of the vertex's value, and running sums over
 * the bins give the spectrum. NaN is outside for every isovalue.
 *
 * Source: X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive datasets on commodity
 * off-the-shelf clusters", 2009, section 4.1.1, after C. Bajaj, V. Pascucci, D. Schikore, "The
 * contour spectrum", 1997.
 *
 * Cost: 2 ns a cell where values are smooth, 3 in noise (vectors of 32 bytes). Memory: 4 bytes a
 * vertex of the largest box, and 32 a bin. For one thread at a time.
 */
class BlockWorkload
{
public:
  explicit BlockWorkload(const SpectrumBins& bins);

  /// Changes the bins. Nothing is counted that was not moved.
  void SetBins(const SpectrumBins& bins);

  /// Adds the cells of the samples' Box. May be called for several blocks.
  void Count(const SampleView& samples);

  /// Adds everything counted since the last call to a spectrum of the same bins; resets this
  /// object.
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
  VertexChanges Vertices;      ///< the value of a vertex is the number of bin edges <= its sample
  std::vector<Change> Changes; ///< by value
  /// The latest changes, PackedSums sums for each value, one number of bins after the other.
  /// Unpacked before the triangles in one could overflow.
  static constexpr std::size_t PackedSums = 2;
  std::vector<std::int64_t> PackedChanges;
  std::size_t PackedVertices = 0;
  std::size_t MinimumValue; ///< of the vertices since the last MoveTo()
  std::size_t MaximumValue = 0;
};

} // namespace isosurface

#endif
