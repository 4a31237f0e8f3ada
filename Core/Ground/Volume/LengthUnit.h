// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LengthUnit_h
#define isosurface_LengthUnit_h

#include <cstdint>
#include <string>

namespace isosurface
{

/// The unit of a grid's coordinates. The numbers are those of edge-index files.
enum class LengthUnit : std::uint8_t
{
  Unknown = 0,
  Meter = 1,
  Decimeter = 2,
  Centimeter = 3,
  Millimeter = 4,
  Micrometer = 5,
  Nanometer = 6,
  Picometer = 7,
  Angstrom = 8,
  Kilometer = 9,
  Inch = 10,
  Foot = 11
};

/// "m", "dm", "cm", "mm", "um", "nm", "pm", "angstrom", "km", "inch", "foot": as files have it, and
/// people read it; "" if it is not known. Null for a number that is none of a unit.
const char* GetLengthUnitName(LengthUnit unit);
/// Its length in meters; 0 if it is not known.
double GetMeters(LengthUnit unit);
/// The unit of these names, of symbols ("um", "µm"), and of words in either spelling, singular or
/// plural, in any case ("Micrometers", "micron"). Unknown for others.
LengthUnit FindLengthUnit(const std::string& name);

} // namespace isosurface

#endif
