// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_InterpolatedArray_h
#define isosurface_InterpolatedArray_h

#include "Surface/Contour/Surface.h"

#include <string>
#include <vector>

namespace isosurface
{

/// A point array of the surface.
struct InterpolatedArray
{
  std::string Name;
  std::vector<std::string> ComponentNames; ///< of all components, or none
  AttributeLayout Layout;

  /// Names of components may differ.
  bool operator==(const InterpolatedArray& other) const
  {
    return this->Name == other.Name && this->Layout.Type == other.Layout.Type &&
      this->Layout.NumberOfComponents == other.Layout.NumberOfComponents;
  }
};

inline std::vector<AttributeLayout> GetLayouts(const std::vector<InterpolatedArray>& arrays)
{
  std::vector<AttributeLayout> layouts;
  for (const InterpolatedArray& array : arrays)
  {
    layouts.push_back(array.Layout);
  }
  return layouts;
}

} // namespace isosurface

#endif
