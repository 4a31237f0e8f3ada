// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Quantizer_h
#define isosurface_Quantizer_h

#include "EdgeIndex/EdgeIndexHeader.h"
#include "EdgeIndex/ValueDomain.h"

#include <cstdint>

namespace isosurface
{

/**
 * Values rounded to equal steps, as the paper has it: a value that comes to lie on the other side
 * of the isovalue by that is shifted to the nearest step on its own side. Codes count steps from
 * the first one that is inside.
 */
class Quantizer
{
public:
  Quantizer(const EdgeIndexSettings& settings, double isovalue);

  ValueDomain MakeDomain(int scale) const;
  std::int64_t ToCode(double value, bool inside) const;
  float ToValue(std::int64_t code) const;
  double GetStep() const { return this->Step; }

private:
  float Restore(std::int64_t step) const;

  double Minimum;
  double Step;
  std::int64_t Last;
  std::int64_t FirstInside = 0;
  float Threshold = 0; ///< the least float that is inside
  float Below = 0;     ///< the greatest that is not
};

} // namespace isosurface

#endif
