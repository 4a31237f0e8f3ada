// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectrumPlot_h
#define isosurface_SpectrumPlot_h

#include "SpectrumCurve.h"

#include <QRect>

#include <QColor>
#include <QStringList>
#include <vector>

class QPainter;
class QPalette;

namespace isosurface
{

constexpr int GripHeight = 11; ///< of the triangle atop a handle

/// How a handle looks.
struct HandleLook
{
  QColor Color;
  QColor Outline;
  bool Selected = false;
};

/// Draws a handle at a pixel column: a line through the plot with a grip above it. One that is out
/// of sight leaves its grip at the side where it is.
void PaintHandle(QPainter& painter, const QRect& plot, double x, const HandleLook& look);

/// Draws lines of text in a box beside a pixel column, on the side that has room.
void PaintReadout(
  QPainter& painter, const QRect& plot, int x, const QStringList& lines, const QPalette& palette);

class ValueAxis;

/**
 * A quantity of a contour spectrum as a curve over the axis of isovalues, before the histogram of
 * the values. The curve is on a logarithmic scale where the quantity spans more than two decades.
 *
 * A value class. It draws within a rectangle, and the labels of the isovalues below that.
 */
class SpectrumPlot
{
public:
  using Quantity = SpectrumCurve::Quantity;

  void SetSpectrum(const SpectrumCurve& spectrum);
  void SetQuantity(Quantity quantity);
  const SpectrumCurve& GetSpectrum() const { return this->Spectrum; }

  void PaintCurves(
    QPainter& painter, const QRect& plot, const ValueAxis& axis, const QPalette& palette) const;
  void PaintAxes(
    QPainter& painter, const QRect& plot, const ValueAxis& axis, const QPalette& palette) const;

private:
  double GetHeight(double value) const; ///< of the quantity: 0 bottom, 1 top
  std::vector<double> MakeHistogramColumns(const QRect& plot, const ValueAxis& axis) const;
  void PaintHistogram(
    QPainter& painter, const QRect& plot, const ValueAxis& axis, const QPalette& palette) const;
  void PaintCurve(QPainter& painter, const QRect& plot, const ValueAxis& axis) const;
  void PaintScale(QPainter& painter, const QRect& plot, const QPalette& palette) const;

  SpectrumCurve Spectrum;
  Quantity Drawn = Quantity::Triangles;
  bool Logarithmic = false;
  double Minimum = 1; ///< of the quantity's positive values
  double Maximum = 1; ///< of the quantity
  std::vector<double> Histogram;
};

} // namespace isosurface

#endif
