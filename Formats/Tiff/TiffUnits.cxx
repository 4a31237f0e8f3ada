// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffUnits.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <iterator>

namespace isosurface
{
namespace
{

struct NamedLength
{
  const char* Name;
  const char* Sign;
  double Metres;
};
constexpr NamedLength NamedLengths[] = { { "m", "m", 1 }, { "meter", "m", 1 }, { "metre", "m", 1 },
  { "dm", "dm", 1e-1 }, { "cm", "cm", 1e-2 }, { "centimeter", "cm", 1e-2 }, { "mm", "mm", 1e-3 },
  { "millimeter", "mm", 1e-3 }, { "\u00B5m", "\u00B5m", 1e-6 }, { "\u03BCm", "\u00B5m", 1e-6 },
  { "um", "\u00B5m", 1e-6 }, { "micron", "\u00B5m", 1e-6 }, { "microns", "\u00B5m", 1e-6 },
  { "micrometer", "\u00B5m", 1e-6 }, { "micrometre", "\u00B5m", 1e-6 }, { "nm", "nm", 1e-9 },
  { "nanometer", "nm", 1e-9 }, { "\u00C5", "\u00C5", 1e-10 }, { "\u212B", "\u00C5", 1e-10 },
  { "angstrom", "\u00C5", 1e-10 }, { "pm", "pm", 1e-12 }, { "km", "km", 1e3 },
  { "in", "in", 0.0254 }, { "inch", "in", 0.0254 }, { "ft", "ft", 0.3048 } };

const NamedLength* FindUnit(const std::string& unit)
{
  const auto* const found = std::find_if(std::begin(NamedLengths), std::end(NamedLengths),
    [&unit](const NamedLength& known)
    { return unit == known.Name || LowerText(unit) == known.Name; });
  return found == std::end(NamedLengths) ? nullptr : found;
}

} // namespace

std::string NormalizeUnit(const std::string& unit)
{
  const std::string text = TrimText(unit);
  const std::string lower = LowerText(text);
  const bool isNone = lower == "pixel" || lower == "pixels" || lower == "reference frame";
  const NamedLength* const found = FindUnit(text);
  return isNone ? "" : found ? found->Sign : text;
}

bool UniteLengths(std::array<double, 3>& lengths, const std::array<std::string, 3>& units)
{
  if (units[1] == units[0] && units[2] == units[0])
  {
    return true;
  }
  const std::array<const NamedLength*, 3> found = { FindUnit(units[0]), FindUnit(units[1]),
    FindUnit(units[2]) };
  if (!found[0] || !found[1] || !found[2])
  {
    return false;
  }
  for (std::size_t axis = 1; axis < 3; ++axis)
  {
    lengths[axis] *= found[axis]->Metres / found[0]->Metres;
  }
  return true;
}

} // namespace isosurface
