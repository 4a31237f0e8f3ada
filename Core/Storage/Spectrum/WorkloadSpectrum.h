// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WorkloadSpectrum_h
#define isosurface_WorkloadSpectrum_h

#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/ValueType.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The isovalues at which a spectrum is sampled: bin b is the isovalue
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
   * Chooses the bins for a range of finite values. The width is the minimum power of two that
   * covers the range with at most 2048 bins (hence at least 1024). But it is at least 1 for
   * integers, and at least the spacing of the type's numbers (at the end of larger magnitude) for
   * floats. So integers of at most 2048 values, such as all 8-bit data, have a bin for every value.
   * The first edge is the last one <= the minimum, the last edge the last one <= the maximum. An
   * empty range has no bins. (For uint64 values above 2^63 the width is at least 2: isovalues are
   * doubles, which cannot distinguish neighbouring values anyway.)
   */
  static SpectrumBins Choose(ValueType type, const KeyRange& finiteRange);

  double GetEdge(std::size_t bin) const;
  std::vector<double> GetEdges() const;
  /// The key of the threshold of an edge: the minimum value of the type >= the edge. The bins must
  /// have been chosen for the type. Exact also where GetEdge() rounds: for large 64-bit integers.
  ValueKey GetEdgeKey(ValueType type, std::size_t bin) const;

  bool operator==(const SpectrumBins& other) const
  {
    return this->First == other.First && this->Exponent == other.Exponent &&
      this->Count == other.Count;
  }
  bool operator!=(const SpectrumBins& other) const { return !(*this == other); }
};

/**
 * Quantities of the isosurface by isovalue, at the edge of every bin. Triangles, cells, blocks and
 * bytes are exact; area and volume are estimates (BlockMeasure). All are integers, so the spectra
 * of parts add up to the spectrum of the whole in any order.
 *
 * A quantity that is not known is an empty vector; the others have Bins.Count elements.
 *
 * Source: C. Bajaj, V. Pascucci, D. Schikore, "The contour spectrum", IEEE Visualization 1997.
 */
struct WorkloadSpectrum
{
  using Counts = std::vector<std::uint64_t>;

  SpectrumBins Bins;
  Counts Triangles;    ///< that marching cubes extracts
  Counts ActiveCells;  ///< cells that the isosurface crosses
  Counts ActiveBlocks; ///< blocks that it crosses
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
  /// One of these quantities; area and volume in the units of the world.
  std::vector<double> Scale(const Counts& quantity) const;

  /// The bin of the last edge <= isovalue; 0 if there is none. The quantities at that edge are
  /// those of the isovalue if it is on the edge, otherwise an approximation.
  std::size_t FindBin(double isovalue) const;

  /// Adds a spectrum of equal bins and units. Returns false, and adds nothing, if these differ. A
  /// quantity that one of the spectra does not know is unknown in the sum.
  bool Add(const WorkloadSpectrum& other);
};

} // namespace isosurface

#endif
