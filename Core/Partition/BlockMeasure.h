// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockMeasure_h
#define isosurface_BlockMeasure_h

#include "Base/Communicator.h"
#include "Partition/WorkloadSpectrum.h"
#include "Volume/GridGeometry.h"
#include "Volume/SampleView.h"
#include "Volume/ValueKey.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Surface area and enclosed volume of many cells by isovalue, as differences from bin to bin.
 * Whole numbers of a fixed unit: their sum is the same in whatever order cells, blocks and ranks
 * are added. Wrapping around 2^64 on the way does no harm, since the results do not.
 */
struct MeasureSums
{
  /// From its bin on: the area, and the volume as Constant - Slope * bin.
  struct Change
  {
    std::uint64_t Area = 0;
    std::uint64_t Constant = 0;
    std::uint64_t Slope = 0;
  };

  /// One of these is the area of the largest face of a cell, or the volume of a cell.
  static constexpr int FractionBits = 20;

  MeasureSums() = default;
  explicit MeasureSums(const SpectrumBins& bins)
    : Changes(bins.Count + std::size_t{ 1 })
  {
  }

  /// Collective: adds those of all ranks, on all ranks.
  void Reduce(Communicator& ranks);

  /// Sets the spectrum's Area and Volume, for the bins that these sums are for.
  void SetMeasures(WorkloadSpectrum& spectrum) const;

  std::vector<Change> Changes; ///< per bin, and one behind the last
};

/// What the squares of a cell's differences weigh in that of its gradient: by the faces normal to
/// the axes that they are differences along, in the square of the largest face.
struct MeasureWeights
{
  float X, Y, Z, XY, XZ, YZ, XYZ;
};

/**
 * Measures the isosurfaces of blocks for all isovalues at once: their area, and the volume where
 * value >= isovalue. The values in a cell are taken to be spread evenly, around the mean and with
 * the variance of its trilinear interpolant (but not beyond its corners' values). So the cell's
 * volume above t falls linearly with t, and by the coarea formula its area is |gradient| * volume /
 * width for every t within that width; |gradient| is the interpolant's root mean square. Both are
 * exact for linear fields. A cell with a corner that is not finite counts for nothing.
 *
 * In a large grid few cells stand for all: of each run of CellsAtOnce cells along x and its
 * neighbours in y, one in `rowStride` is measured. Which one takes turns along x and z, in an
 * order that differs from place to place, lest it keeps step with the surface. The choice depends
 * on the cells' place in the grid alone, so sums over blocks do not depend on how the grid is cut.
 *
 * Source: C. Bajaj, V. Pascucci, D. Schikore, "The contour spectrum", IEEE Visualization 1997,
 * which integrates splines over simplices exactly; here by the coarea formula as in C. Scheidegger,
 * J. Schreiner, B. Duffy, H. Carr, C. Silva, "Revisiting histograms and isosurface statistics",
 * IEEE TVCG 14(6), 2008, for a fraction of the cost.
 *
 * Memory: 24 bytes a bin. One object serves one thread at a time.
 */
class BlockMeasure
{
public:
  BlockMeasure(const SpectrumBins& bins, const GridGeometry& grid)
    : BlockMeasure(bins, grid, ChooseRowStride(grid))
  {
  }
  /// rowStride: 1, 2, 4 or 8.
  BlockMeasure(const SpectrumBins& bins, const GridGeometry& grid, std::int64_t rowStride);

  /// One row in so many is measured: the more, the larger the grid is. Errors grow with the stride
  /// and fall with the side of the grid, so that a surface across it has one of about 3 %; small
  /// ones more.
  static std::int64_t ChooseRowStride(const GridGeometry& grid);

  /// Adds the cells of the samples' Box, which is in the grid's coordinates.
  void Count(const SampleView& samples);

  /// Adds the cells of a box that has but one value, of this key.
  void CountUniform(ValueType type, ValueKey key, const VertexBox& box);

  /// Adds what was counted since the last call, and forgets it.
  void MoveTo(MeasureSums& sums);

  /// The units of a spectrum's Area and Volume.
  static double GetAreaUnit(const GridGeometry& grid);
  static double GetVolumeUnit(const GridGeometry& grid);

private:
  static constexpr std::int64_t CellsAtOnce = 16;
  using CellRow = std::array<float, CellsAtOnce + 1>;

  /// What a run of cells adds: from bin From on the area is Area and the volume First, which falls
  /// by Slope a bin; from bin To on there is neither. Below From the volume is one cell.
  struct CellRun
  {
    std::array<std::int32_t, CellsAtOnce> From;
    std::array<std::int32_t, CellsAtOnce> To;
    std::array<std::int32_t, CellsAtOnce> Area;
    std::array<std::int32_t, CellsAtOnce> First;
    std::array<std::int32_t, CellsAtOnce> Slope;
  };

  template <typename T>
  void CountCells(const SampleView& samples);
  std::int64_t ChooseRow(std::int64_t run, std::int64_t group, std::int64_t k) const;
  void CountRun(const std::array<CellRow, 4>& rows, std::int64_t cells, std::int64_t weight);
  void AddRun(const CellRun& run, std::int64_t cells, std::uint64_t one);

  SpectrumBins Bins;
  std::int64_t RowsOfCells; ///< of the grid, in y
  std::int64_t RowStride;
  MeasureWeights Weights;
  MeasureSums Sums;
  std::size_t LowestBin;
  std::size_t HighestBin;
};

} // namespace isosurface

#endif
