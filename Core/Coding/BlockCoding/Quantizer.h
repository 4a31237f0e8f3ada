// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Quantizer_h
#define isosurface_Quantizer_h

#include "Coding/BlockCoding/ValueDomain.h"

#include <cstdint>

namespace isosurface
{

/**
 * Rounds values to 2^bits levels at equal steps, from a minimum to a maximum above it. A value that
 * rounding would bring to the other side of the isovalue is moved to the nearest level on its own
 * side. Codes count levels from the first one inside. NaN has a code of its own below all others.
 */
class Quantizer
{
public:
  /// `withNotANumber`: whether values may be NaN, as those of floats.
  Quantizer(double minimum, double maximum, int bits, double isovalue, bool withNotANumber);

  /// The domain of the codes. scale: see ValueDomain::ToHeight.
  ValueDomain MakeDomain(int scale) const;
  /// `inside` is the value's sign. Where there is no NaN, it becomes the minimum.
  std::int64_t ToCode(double value, bool inside) const;
  float ToValue(std::int64_t code) const;
  /// The difference of two levels.
  double GetStep() const { return this->Step; }

private:
  float Restore(std::int64_t level) const;

  double Minimum;
  double Step;
  std::int64_t Last; ///< the last level; the first one is 0
  std::int64_t FirstInside = 0;
  std::int64_t NotANumber =
    0;                 ///< its code; 0, which is no code of a value outside, if there is none
  float Threshold = 0; ///< the minimum float that is inside
  float Below = 0;     ///< the maximum float that is outside
};

} // namespace isosurface

#endif
