// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffUnits.h"

#include "Formats/Source/TextFields.h"
#include "Ground/Volume/LengthUnit.h"

#include <algorithm>

namespace isosurface
{

std::string NormalizeUnit(const std::string& unit)
{
  const std::string text = TrimText(unit);
  const std::string lower = LowerText(text);
  return lower == "pixel" || lower == "pixels" || lower == "reference frame" ? "" : text;
}

bool UniteLengths(std::array<double, 3>& lengths, const std::array<std::string, 3>& units)
{
  if (units[1] == units[0] && units[2] == units[0])
  {
    return true;
  }
  std::array<double, 3> meters = {};
  std::transform(units.begin(), units.end(), meters.begin(),
    [](const std::string& unit) { return GetMeters(FindLengthUnit(unit)); });
  if (std::count(meters.begin(), meters.end(), 0.0) > 0)
  {
    return false;
  }
  for (std::size_t axis = 1; axis < 3; ++axis)
  {
    lengths[axis] *= meters[axis] / meters[0];
  }
  return true;
}

} // namespace isosurface
