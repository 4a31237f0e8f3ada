// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueAxis_h
#define isosurface_ValueAxis_h

#include <vector>

namespace isosurface
{

/**
 * A horizontal axis of values on the screen that can be zoomed: maps values to pixels and back,
 * and rounds values to what a hand can set.
 *
 * The visible range is always within the full range, and never narrower than the smallest step of
 * the values. A value class.
 */
class ValueAxis
{
public:
  /// Sets all values there are, and shows them. A single value gets a range around it. integers:
  /// whether values between whole numbers mean nothing.
  void SetRange(double minimum, double maximum, bool integers);

  /// The pixels that the visible range takes: from left on, width > 0.
  void SetPixels(double left, double width);

  double GetMinimum() const { return this->Low; } ///< of the visible range
  double GetMaximum() const { return this->High; }
  bool IsZoomed() const { return this->Low != this->FullLow || this->High != this->FullHigh; }

  double ToPixel(double value) const;
  double ToValue(double pixel) const;

  /// Makes the visible range `factor` times as narrow; the value at a pixel stays there, unless
  /// that would show values beyond the full range.
  void Zoom(double pixel, double factor);
  /// Moves the visible range such that what was at one pixel is at another one.
  void Pan(double fromPixel, double toPixel);
  void ShowAll();
  /// Moves the visible range as little as is needed to show a value of the full range.
  void Show(double value);

  /// The value that is meant by one near it: a whole number, or one of as few digits as pixels can
  /// tell apart; within the full range.
  double Snap(double value) const;
  /// By how much a fine step changes a value: 1, or the power of ten below a pixel.
  double GetStep() const;

  /// Round values to label, at least `spacing` pixels from each other.
  std::vector<double> MakeTicks(double spacing) const;

private:
  void SetVisible(double low, double high);

  double FullLow = 0;
  double FullHigh = 1;
  double Low = 0;
  double High = 1;
  double Left = 0;
  double Width = 1;
  bool Integers = false;
};

} // namespace isosurface

#endif
