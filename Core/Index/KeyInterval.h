// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_KeyInterval_h
#define isosurface_KeyInterval_h

#include "Volume/ValueKey.h"

#include <cstdint>

namespace isosurface
{

/**
 * The closed interval [Minimum, Maximum] of keys that something covers (a block, usually) and the
 * number of that something. Payloads end at 2^32 - 1: blocks are counted within one store.
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
