// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/Quantizer.h"

#include "Ground/Volume/ValueKey.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isosurface
{

Quantizer::Quantizer(double minimum, double maximum, int bits, double isovalue, bool withNotANumber)
  : Minimum(minimum)
  , Last((std::int64_t(1) << bits) - 1)
{
  this->Step = (maximum - minimum) / static_cast<double>(this->Last);
  this->Threshold = FindThreshold<float>(isovalue).value_or(std::numeric_limits<float>::infinity());
  this->Below = std::nextafter(this->Threshold, -std::numeric_limits<float>::infinity());
  std::int64_t low = 0;
  std::int64_t high = this->Last + 1;
  while (low < high)
  {
    const std::int64_t middle = (low + high) / 2;
    if (this->Restore(middle) >= this->Threshold)
    {
      high = middle;
    }
    else
    {
      low = middle + 1;
    }
  }
  this->FirstInside = low;
  this->NotANumber = withNotANumber ? std::min<std::int64_t>(-1, -this->FirstInside) - 1 : 0;
}

float Quantizer::Restore(std::int64_t level) const
{
  const double value = this->Minimum + static_cast<double>(level) * this->Step;
  constexpr auto maximum = static_cast<double>(std::numeric_limits<float>::max());
  return static_cast<float>(std::clamp(value, -maximum, maximum));
}

ValueDomain Quantizer::MakeDomain(int scale) const
{
  const std::int64_t least = std::min<std::int64_t>(-1, -this->FirstInside);
  return ValueDomain::MakeQuantized(std::min(least, this->NotANumber),
    std::max<std::int64_t>(0, this->Last - this->FirstInside), scale);
}

std::int64_t Quantizer::ToCode(double value, bool inside) const
{
  if (std::isnan(value) && this->NotANumber != 0)
  {
    return this->NotANumber;
  }
  const double level = std::floor((value - this->Minimum) / this->Step + 0.5);
  const auto last = static_cast<double>(this->Last);
  const std::int64_t nearest = level >= last ? this->Last
    : level > 0                              ? static_cast<std::int64_t>(level)
                                             : 0; // NaN, too
  const std::int64_t code = nearest - this->FirstInside;
  return inside ? std::max<std::int64_t>(code, 0) : std::min<std::int64_t>(code, -1);
}

float Quantizer::ToValue(std::int64_t code) const
{
  if (code <= this->NotANumber && this->NotANumber != 0)
  {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const float value = this->Restore(code + this->FirstInside);
  return code >= 0 ? std::max(value, this->Threshold) : std::min(value, this->Below);
}

} // namespace isosurface
