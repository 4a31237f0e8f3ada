// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/LengthUnit.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>

namespace isosurface
{
namespace
{

/// The units in the order of their numbers.
struct UnitNames
{
  const char* Name;
  double Meters;
  std::array<const char*, 4> Words;   ///< in lower case; also with an s behind
  std::array<const char*, 2> Symbols; ///< others than Name
};
constexpr UnitNames Units[] = {
  { "", 0, {}, {} },
  { "m", 1, { "meter", "metre" }, {} },
  { "dm", 1e-1, { "decimeter", "decimetre" }, {} },
  { "cm", 1e-2, { "centimeter", "centimetre" }, {} },
  { "mm", 1e-3, { "millimeter", "millimetre" }, {} },
  // The micro sign, and the Greek letter.
  { "um", 1e-6, { "micrometer", "micrometre", "micron" }, { "\xC2\xB5m", "\xCE\xBCm" } },
  { "nm", 1e-9, { "nanometer", "nanometre" }, {} },
  { "pm", 1e-12, { "picometer", "picometre" }, {} },
  // The letter A with a ring, and the sign of the unit.
  { "angstrom", 1e-10, { "angstrom", "\xC3\xA5ngstr\xC3\xB6m" }, { "\xC3\x85", "\xE2\x84\xAB" } },
  { "km", 1e3, { "kilometer", "kilometre" }, {} },
  { "inch", 0.0254, { "inch", "inches" }, { "in" } },
  { "foot", 0.3048, { "foot", "feet" }, { "ft" } },
};

bool HasName(const UnitNames& unit, const std::string& name)
{
  std::string word = name;
  std::transform(word.begin(), word.end(), word.begin(),
    [](unsigned char letter)
    { return letter < 128 ? static_cast<char>(std::tolower(letter)) : static_cast<char>(letter); });
  const auto isSymbol = [&](const char* symbol) { return symbol && name == symbol; };
  const auto isWord = [&](const char* singular)
  { return singular && (word == singular || word == singular + std::string("s")); };
  return name == unit.Name || std::any_of(unit.Symbols.begin(), unit.Symbols.end(), isSymbol) ||
    std::any_of(unit.Words.begin(), unit.Words.end(), isWord);
}

} // namespace

const char* GetLengthUnitName(LengthUnit unit)
{
  const auto number = static_cast<std::size_t>(unit);
  return number < std::size(Units) ? Units[number].Name : nullptr;
}

double GetMeters(LengthUnit unit)
{
  const auto number = static_cast<std::size_t>(unit);
  return number < std::size(Units) ? Units[number].Meters : 0;
}

LengthUnit FindLengthUnit(const std::string& name)
{
  const auto found = std::find_if(
    std::begin(Units), std::end(Units), [&](const UnitNames& unit) { return HasName(unit, name); });
  return found == std::end(Units) ? LengthUnit::Unknown
                                  : static_cast<LengthUnit>(found - std::begin(Units));
}

} // namespace isosurface
