// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WorkloadSpectrum_h
#define isosurface_WorkloadSpectrum_h

#include "Volume/ValueKey.h"
#include "Volume/ValueType.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The isovalues at which a spectrum is sampled: bin b stands for the isovalue
 * GetEdge(b) = (First + b) * 2^Exponent, for b in [0, Count).
 *
 * Every width is a power of two, and every edge a multiple of the width. So the edges of coarser
 * bins are edges of finer ones, whatever ranges the two were made for.
 */
struct SpectrumBins
{
  /// Never more bins than this.
  static constexpr std::uint32_t MaximumCount = 2048;

  std::int64_t First = 0;
  std::int32_t Exponent = 0;
  std::uint32_t Count = 0;

  /**
   * The bins for a range of finite values (infinities and NaN left out): the least power of two
   * that covers it by at most 2048 bins (hence at least 1024), but for integers not less than 1,
   * for floats not less than the spacing of the type's numbers at the end of larger magnitude. So
   * integers of at most 2048 values, all 8-bit data among them, have a bin for every value. The
   * first edge is the last one <= the minimum, the last edge the last one <= the maximum. An empty
   * range has no bins. (uint64 values from 2^63 on have a width of at least 2; an isovalue, being a
   * double, cannot tell them apart anyway.)
   */
  static SpectrumBins Choose(ValueType type, const KeyRange& finiteRange);

  double GetWidth() const;
  double GetEdge(std::size_t bin) const;
  /// The key of the least value of the type, of a range that these bins were chosen for, that is
  /// not below an edge. Exact where GetEdge is not, for 64-bit integers of many digits.
  ValueKey GetEdgeKey(ValueType type, std::size_t bin) const;

  bool operator==(const SpectrumBins& other) const
  {
    return this->First == other.First && this->Exponent == other.Exponent &&
      this->Count == other.Count;
  }
  bool operator!=(const SpectrumBins& other) const { return !(*this == other); }
};

/**
 * What an isosurface is and costs, by isovalue: at the edge of every bin. Triangles, cells, blocks
 * and bytes are exact, with inside meaning value >= isovalue; area and volume are estimates
 * (BlockMeasure). All are whole numbers, so the spectra of parts add up to that of the whole in any
 * order.
 *
 * A quantity that is not known, as in files of older versions, is an empty vector; the others have
 * Bins.Count elements.
 *
 * Source: C. Bajaj, V. Pascucci, D. Schikore, "The contour spectrum", IEEE Visualization 1997.
 */
struct WorkloadSpectrum
{
  using Counts = std::vector<std::uint64_t>;

  SpectrumBins Bins;
  Counts Triangles;    ///< that marching cubes extracts
  Counts ActiveCells;  ///< cells that the isosurface passes
  Counts ActiveBlocks; ///< blocks with values on both sides
  Counts Bytes;        ///< that a query reads of the active blocks
  Counts Area;         ///< of the isosurface, in AreaUnit
  Counts Volume;       ///< where value >= isovalue, in VolumeUnit
  double AreaUnit = 0;
  double VolumeUnit = 0;

  WorkloadSpectrum() = default;
  /// All counts 0.
  explicit WorkloadSpectrum(const SpectrumBins& bins);

  /// All quantities, in the order above.
  static constexpr std::size_t NumberOfQuantities = 6;
  std::array<Counts*, NumberOfQuantities> GetQuantities();
  std::array<const Counts*, NumberOfQuantities> GetQuantities() const;

  /// The bin whose edge is the last one <= isovalue, clamped to the bins; 0 if there is none. Exact
  /// for an isovalue on an edge, else a close guess.
  std::size_t FindBin(double isovalue) const;

  /// Adds a spectrum of equal bins and units; false (and nothing added) if these differ. What one
  /// of the two does not know, the sum does not know either.
  bool Add(const WorkloadSpectrum& other);
};

} // namespace isosurface

#endif
