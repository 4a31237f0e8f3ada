// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_KeyInterval_h
#define isosurface_KeyInterval_h

#include "Ground/Volume/ValueKey.h"

#include <cstdint>

namespace isosurface
{

/**
 * A closed interval [Minimum, Maximum] of keys with a payload: usually the value range of a block
 * and its number within its store.
 */
struct KeyInterval
{
  ValueKey Minimum = 0;
  ValueKey Maximum = 0;
  std::uint32_t Payload = 0;

  bool Overlaps(ValueKey low, ValueKey high) const
  {
    return this->Minimum <= high && this->Maximum >= low;
  }
};

} // namespace isosurface

#endif
