// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GrowingSpectrum_h
#define isosurface_GrowingSpectrum_h

#include "Ground/Base/Coding.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Spectrum/BlockMeasure.h"
#include "Storage/Spectrum/BlockWorkload.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// What the isosurface of an isovalue is; area and volume in the units of MeasureSums. Differences
/// may wrap around 2^64; sums of them do not.
struct SurfaceSums
{
  std::uint64_t Triangles = 0;
  std::uint64_t Cells = 0;
  std::uint64_t Area = 0;
  std::uint64_t Volume = 0;

  SurfaceSums& operator+=(const SurfaceSums& other);
  SurfaceSums operator-(const SurfaceSums& other) const;
};

/// The isosurfaces of cells at the edges of the bins of their range. Below the first edge and above
/// the last one nothing changes: there only samples that are not finite differ.
struct EdgeSums
{
  KeyRange Range; ///< of the finite samples
  SpectrumBins Bins;
  SurfaceSums Below;
  std::vector<SurfaceSums> Edges; ///< at least Bins.Count
  SurfaceSums Above;
};

/// Counts and measures one block at a time, in bins of the block's own range. So the numbers do not
/// depend on what else is in the volume. For one thread at a time.
class BlockSpectrum
{
public:
  explicit BlockSpectrum(const MeasuredGrid& grid)
    : Workload({})
    , Measure({}, grid)
  {
  }

  /// The isosurfaces of a block; valid until the next call. `range`: that of the samples' Box.
  const EdgeSums& Count(const SampleView& samples, const SampleRange& range);

private:
  void SumEdges();

  BlockWorkload Workload;
  BlockMeasure Measure;
  WorkloadSpectrum Counts;
  MeasureSums Measures;
  EdgeSums Sums;
};

/**
 * The sum of the spectra of blocks whose common range becomes known with the last one. Its bins are
 * those of the range of the blocks so far (SpectrumBins::Choose). A larger range has wider bins,
 * whose edges are among those of the narrower ones; so no number is rounded when the bins grow, and
 * the result does not depend on the order of the blocks. Memory: 32 bytes a bin.
 */
class GrowingSpectrum
{
public:
  explicit GrowingSpectrum(ValueType type)
    : Type(type)
    , Changes(1)
  {
  }

  /// Adds the isosurfaces of cells of the type.
  void Add(const EdgeSums& sums);
  /// Makes the bins those of this range and the range so far.
  void Grow(const KeyRange& range);

  /// Sets triangles, cells, area and volume of a spectrum whose bins are those of this range. False if
  /// that does not contain the ranges of all blocks.
  bool SetSums(WorkloadSpectrum& spectrum, const KeyRange& range);

  /// Appends all it knows, about 32 bytes a bin, and sets another one of the type by that. False if
  /// the bytes are of no spectrum of the type.
  void AppendTo(std::vector<std::uint8_t>& bytes) const;
  bool ReadFrom(ByteReader& reader);

private:
  void AddInBins(const EdgeSums& sums);
  EdgeSums Resolve() const;

  ValueType Type;
  KeyRange Range;
  SpectrumBins Bins;
  SurfaceSums Below;                ///< the first edge
  std::vector<SurfaceSums> Changes; ///< at each edge, from the one before, and above the last one
};

} // namespace isosurface

#endif
