// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectrumCurve_h
#define isosurface_SpectrumCurve_h

#include <array>
#include <cstddef>
#include <vector>

namespace isosurface
{

/// What the isosurface of one isovalue is and costs.
struct IsosurfaceForecast
{
  double Triangles = 0;
  double Blocks = 0; ///< active ones
  double Bytes = 0;  ///< to read of these
  double Area = 0;   ///< in world units
};

/**
 * A contour spectrum as the window has it: quantities of the isosurface at rising isovalues.
 *
 * A value class, made of the columns of vtkContourSpectrum. A quantity that is not known, as of
 * volumes of older versions, has no values.
 */
class SpectrumCurve
{
public:
  /// In the order of vtkContourSpectrum's columns.
  enum class Quantity
  {
    Triangles,
    ActiveCells,
    ActiveBlocks,
    Bytes,
    Area,
    Volume
  };
  static constexpr std::size_t NumberOfQuantities = 6;
  /// Of the property Spectrum: an isovalue, then its quantities.
  static constexpr std::size_t RowLength = 1 + NumberOfQuantities;
  using Columns = std::array<std::vector<double>, NumberOfQuantities>;

  SpectrumCurve() = default;
  /// isovalues: rising. Columns of another length than isovalues count as not known.
  /// integers: whether the samples are whole numbers.
  SpectrumCurve(std::vector<double> isovalues, Columns columns, bool integers);

  bool IsEmpty() const { return this->Isovalues.empty(); }
  bool HasIntegers() const { return this->Integers; }
  bool Knows(Quantity quantity) const { return !this->Get(quantity).empty(); }
  const std::vector<double>& GetIsovalues() const { return this->Isovalues; }
  const std::vector<double>& Get(Quantity quantity) const;

  /// A quantity at any isovalue: interpolated between two of the spectrum, 0 beyond its ends or if
  /// it is not known. Of integers the surface changes at whole numbers only, and so does this.
  double Evaluate(Quantity quantity, double isovalue) const;

  IsosurfaceForecast Forecast(double isovalue) const;

  /// How much of the volume has values from one isovalue to the next, for each but the last one;
  /// nothing if Volume is not known.
  std::vector<double> MakeHistogram() const;

  /// Whether a quantity is better seen on a logarithmic scale: its positive values span more than
  /// two decades.
  bool SpansDecades(Quantity quantity) const;

private:
  std::vector<double> Isovalues;
  Columns Values;
  bool Integers = false;
};

} // namespace isosurface

#endif
