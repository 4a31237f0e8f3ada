// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockMeasure_h
#define isosurface_BlockMeasure_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Spectrum/CellMeasure.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Surface area and enclosed volume by isovalue, summed over many cells, as differences from bin to
 * bin. The numbers are integers in a fixed unit, so the sums do not depend on the order of cells,
 * blocks and ranks. Intermediate sums may wrap around 2^64; the results do not.
 */
struct MeasureSums
{
  /// Added from its bin on: the area, and the volume Constant - Slope * bin.
  struct Change
  {
    std::uint64_t Area = 0;
    std::uint64_t Constant = 0;
    std::uint64_t Slope = 0;

    Change& operator+=(const Change& other)
    {
      this->Area += other.Area;
      this->Constant += other.Constant;
      this->Slope += other.Slope;
      return *this;
    }
  };

  /// 2^FractionBits units are the area of the largest face of a cell, or the volume of a cell.
  static constexpr int FractionBits = 20;

  MeasureSums() = default;
  explicit MeasureSums(const SpectrumBins& bins)
    : Changes(bins.Count + std::size_t{ 1 })
  {
  }

  /// The changes one after the other, for ranks to add up, and from there.
  std::vector<std::uint64_t> GetNumbers() const;
  void SetNumbers(const std::vector<std::uint64_t>& numbers);

  /// The area or volume in a spectrum, of a sum of changes.
  static std::uint64_t Round(std::uint64_t sum);
  /// Sets Area and Volume of a spectrum that has the bins of these sums.
  void SetMeasures(WorkloadSpectrum& spectrum) const;

  std::vector<Change> Changes; ///< by bin, and one after the last
};

/// The grid of the cells that are measured.
struct MeasuredGrid
{
  /// Of a rectilinear grid, one of cells of the mean size (GridLines::MakeFrame).
  GridGeometry Geometry;
  const GridLines* Lines = nullptr; ///< of a rectilinear grid; they must outlive the measure
};

/**
 * Estimates, for all isovalues at once, the area of the isosurface in blocks, and the volume where
 * value >= isovalue. Assumes that the values in a cell are evenly distributed, with the mean and
 * the variance of the trilinear interpolant. So the cell's volume above t falls linearly with t,
 * and its area is |gradient| * volume / width by the coarea formula. Exact for linear fields. Cells
 * with samples that are not finite are left out.
 *
 * Large grids are sampled: of `rowStride` neighbouring rows of cells one is measured; which one
 * changes pseudorandomly every CellsAtOnce cells. That depends on the place in the grid only, so
 * the sums do not depend on how the grid is cut into blocks. In a rectilinear grid the measured row
 * stands for the height of all rows, and runs of cells of one length are measured at once.
 *
 * Source: C. Bajaj, V. Pascucci, D. Schikore, "The contour spectrum", IEEE Visualization 1997; the
 * coarea formula as in C. Scheidegger et al., "Revisiting histograms and isosurface statistics",
 * IEEE TVCG 14(6), 2008, instead of exact integrals of splines. Memory: 24 bytes a bin. For one
 * thread at a time.
 */
class BlockMeasure
{
public:
  BlockMeasure(const SpectrumBins& bins, const MeasuredGrid& grid)
    : BlockMeasure(bins, grid, ChooseRowStride(grid.Geometry))
  {
  }
  BlockMeasure(const SpectrumBins& bins, const GridGeometry& grid)
    : BlockMeasure(bins, MeasuredGrid{ grid })
  {
  }
  /// rowStride: 1, 2, 4 or 8.
  BlockMeasure(const SpectrumBins& bins, const MeasuredGrid& grid, std::int64_t rowStride);
  BlockMeasure(const SpectrumBins& bins, const GridGeometry& grid, std::int64_t rowStride)
    : BlockMeasure(bins, MeasuredGrid{ grid }, rowStride)
  {
  }

  /// The stride of measured rows: one row in each stride is measured. It grows with the grid.
  /// Errors grow with the stride and fall with the side of the grid: the error of a surface across
  /// the grid is about 3 %, that of a small surface more.
  static std::int64_t ChooseRowStride(const GridGeometry& grid);

  /// Changes the bins. Nothing is counted that was not moved.
  void SetBins(const SpectrumBins& bins);

  /// Adds the cells of the samples' Box, which is in coordinates of the grid.
  void Count(const SampleView& samples);

  /// Adds the cells of a box whose samples all have the value of this key.
  void CountUniform(ValueType type, ValueKey key, const VertexBox& box);

  /// Adds everything counted since the last call to `sums`, and resets this object.
  void MoveTo(MeasureSums& sums);

  /// The units of a spectrum's Area and Volume.
  static double GetAreaUnit(const GridGeometry& grid);
  static double GetVolumeUnit(const GridGeometry& grid);

private:
  static constexpr std::int64_t CellsAtOnce = 16; ///< of a run
  /// Runs are measured several at once, so that the processor need not wait for roots and
  /// quotients.
  static constexpr std::int64_t RunsAtOnce = 16;
  /// A run is followed by its last vertex, where no cell of it begins.
  static constexpr std::int64_t PlacesAtOnce = RunsAtOnce * (CellsAtOnce + 1);
  using CellRow = std::array<float, PlacesAtOnce>;

  /// The results for runs of cells. Below bin From, the volume is one cell. In the bins From to
  /// To - 1, the area is Area; the volume is First at From and falls by Slope from bin to bin. From
  /// To on, both are 0.
  struct CellRun
  {
    std::array<std::int32_t, PlacesAtOnce> From;
    std::array<std::int32_t, PlacesAtOnce> To;
    std::array<std::int32_t, PlacesAtOnce> Area;
    std::array<std::int32_t, PlacesAtOnce> First;
    std::array<std::int32_t, PlacesAtOnce> Slope;
  };

  /// Runs that wait to be measured, one after another. All weigh the same.
  struct PendingRuns
  {
    std::array<CellRow, 4> Rows;
    std::array<std::int64_t, RunsAtOnce> Ends; ///< the place of each run's last vertex
    std::int64_t Count = 0;
    std::int64_t Places = 0;
    std::int64_t Weight = 0;
  };

  /// One row of cells along x, and the rows that it stands for.
  struct RowPlace
  {
    std::int64_t J;
    std::int64_t K;
    std::int64_t FirstRow;
    std::int64_t Rows;
  };

  template <typename T>
  void CountCells(const SampleView& samples);
  /// `coordinate`: converts values of type T to bins.
  template <typename T, typename Coordinate>
  void CountRow(const SampleView& samples, const Coordinate& coordinate, std::int64_t begin,
    std::int64_t end, const RowPlace& row);
  std::int64_t ChooseRow(std::int64_t run, std::int64_t group, std::int64_t k) const;
  /// Measures the pending runs, and adds them to the sums.
  void CountPending();
  /// The same in a rectilinear grid, for cells of one length.
  void CountLinedRun(const std::array<CellRow, 4>& rows, std::int64_t begin, std::int64_t cells,
    const RowPlace& place);
  void AddRun(const CellRun& run, std::int64_t cells, std::uint64_t one);
  void AddCell(
    std::int32_t from, std::int32_t to, const MeasureSums::Change& change, std::uint64_t one);
  std::uint64_t GetVolume(const VertexBox& box) const;
  /// The length of cells of a rectilinear grid on an axis, relative to the mean.
  double GetLength(std::size_t axis, std::int64_t cell, std::int64_t cells = 1) const;

  SpectrumBins Bins;
  MeasuredGrid Grid;
  std::int64_t RowsOfCells; ///< of the grid, in y
  std::int64_t RowStride;
  MeasureWeights Weights;
  PendingRuns Pending;
  MeasureSums Sums;
};

} // namespace isosurface

#endif
