// SPDX-License-Identifier: BSD-3-Clause
#include "ValueAxis.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

/// Doubles of the full range's size are told apart down to about this share of it.
constexpr double FinestShare = 1e-9;

/// The minimum number that is 1, 2 or 5 times a power of ten and at least `least` > 0.
double RoundUp(double least)
{
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : { 1.0, 2.0, 5.0 })
  {
    // The logarithm of a power of ten may be a little off.
    if (factor * power >= least * (1 - 1e-9))
    {
      return factor * power;
    }
  }
  return 10 * power;
}

} // namespace

void ValueAxis::SetRange(double minimum, double maximum, bool integers)
{
  this->Integers = integers;
  const bool empty = !(maximum > minimum);
  const double margin = !empty ? 0 : integers ? 1 : std::max(1e-6, std::abs(minimum) * 1e-3);
  this->FullLow = minimum - margin;
  this->FullHigh = (empty ? minimum : maximum) + margin;
  this->ShowAll();
}

void ValueAxis::SetPixels(double left, double width)
{
  this->Left = left;
  this->Width = std::max(1.0, width);
}

double ValueAxis::ToPixel(double value) const
{
  return this->Left + (value - this->Low) / (this->High - this->Low) * this->Width;
}

double ValueAxis::ToValue(double pixel) const
{
  return this->Low + (pixel - this->Left) / this->Width * (this->High - this->Low);
}

void ValueAxis::SetVisible(double low, double high)
{
  const double full = this->FullHigh - this->FullLow;
  const double finest = std::min(full, this->Integers ? 4.0 : full * FinestShare);
  const double length = std::clamp(high - low, finest, full);
  const double middle = (low + high) / 2;
  this->Low = std::clamp(middle - length / 2, this->FullLow, this->FullHigh - length);
  this->High = length == full ? this->FullHigh : this->Low + length;
}

void ValueAxis::Zoom(double pixel, double factor)
{
  const double fixed = this->ToValue(pixel);
  this->SetVisible(fixed - (fixed - this->Low) / factor, fixed + (this->High - fixed) / factor);
}

void ValueAxis::Pan(double fromPixel, double toPixel)
{
  const double change = this->ToValue(fromPixel) - this->ToValue(toPixel);
  this->SetVisible(this->Low + change, this->High + change);
}

void ValueAxis::ShowAll()
{
  this->Low = this->FullLow;
  this->High = this->FullHigh;
}

void ValueAxis::Show(double value)
{
  const double shown = std::clamp(value, this->FullLow, this->FullHigh);
  const double change = std::min(0.0, shown - this->Low) + std::max(0.0, shown - this->High);
  if (change != 0)
  {
    this->SetVisible(this->Low + change, this->High + change);
  }
}

double ValueAxis::GetStep() const
{
  const double pixel = (this->High - this->Low) / this->Width;
  const double step = std::pow(10.0, std::floor(std::log10(pixel)));
  return this->Integers ? std::max(1.0, step) : step;
}

double ValueAxis::Snap(double value) const
{
  // Rounded by a division where the step is below 1: 123 / 100 is the double nearest to 1.23, and
  // 123 * 0.01 is not.
  const double step = this->Integers ? 1 : this->GetStep();
  const double inverse = std::round(1 / step);
  double snapped = value;
  if (step >= 1)
  {
    snapped = std::round(value / step) * step;
  }
  else if (std::isfinite(value * inverse))
  {
    snapped = std::round(value * inverse) / inverse;
  }
  return std::clamp(snapped, this->FullLow, this->FullHigh);
}

std::vector<double> ValueAxis::MakeTicks(double spacing) const
{
  const double pixel = (this->High - this->Low) / this->Width;
  const double least = pixel * std::max(1.0, spacing);
  const double step = RoundUp(this->Integers ? std::max(1.0, least) : least);
  std::vector<double> ticks;
  for (double count = std::ceil(this->Low / step); count * step <= this->High; ++count)
  {
    ticks.push_back(count * step);
  }
  return ticks;
}

} // namespace isosurface
