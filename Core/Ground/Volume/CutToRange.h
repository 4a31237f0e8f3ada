// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CutToRange_h
#define isosurface_CutToRange_h

#include <limits>
#include <type_traits>

namespace isosurface
{

/// A number as a sample: of an integer type its whole part, at most the type's extreme numbers. NaN is
/// then the minimum.
template <typename T>
T CutToRange(double number)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    return static_cast<T>(number);
  }
  else
  {
    // The maximum of 64 bits is no double: the next one is beyond the type.
    constexpr auto low = static_cast<double>(std::numeric_limits<T>::min());
    constexpr auto high = static_cast<double>(std::numeric_limits<T>::max());
    return number >= high ? std::numeric_limits<T>::max()
      : number > low      ? static_cast<T>(number)
                          : std::numeric_limits<T>::min();
  }
}

} // namespace isosurface

#endif
