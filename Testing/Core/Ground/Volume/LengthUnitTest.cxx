// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/LengthUnit.h"

#include <gtest/gtest.h>

#include <set>

using namespace isosurface;

TEST(LengthUnit, EachHasANameOfItsOwnThatFindsItAndALength)
{
  std::set<std::string> names;
  for (std::uint8_t number = 0; GetLengthUnitName(static_cast<LengthUnit>(number)); ++number)
  {
    const auto unit = static_cast<LengthUnit>(number);
    EXPECT_TRUE(names.insert(GetLengthUnitName(unit)).second);
    EXPECT_EQ(FindLengthUnit(GetLengthUnitName(unit)), unit);
    EXPECT_EQ(GetMeters(unit) > 0, unit != LengthUnit::Unknown);
  }
  EXPECT_EQ(names.size(), std::size_t{ 12 });
  EXPECT_EQ(GetMeters(static_cast<LengthUnit>(200)), 0);
}

TEST(LengthUnit, IsFoundByTheSpellingsOfFiles)
{
  const std::pair<const char*, LengthUnit> spellings[] = { { "Millimeter", LengthUnit::Millimeter },
    { "millimetres", LengthUnit::Millimeter }, { "micron", LengthUnit::Micrometer },
    { "Microns", LengthUnit::Micrometer }, { "micrometer", LengthUnit::Micrometer },
    { "\xC2\xB5m", LengthUnit::Micrometer }, { "\xCE\xBCm", LengthUnit::Micrometer },
    { "Angstrom", LengthUnit::Angstrom }, { "\xC3\x85", LengthUnit::Angstrom },
    { "in", LengthUnit::Inch }, { "Inches", LengthUnit::Inch }, { "feet", LengthUnit::Foot },
    { "METERS", LengthUnit::Meter } };
  for (const auto& [name, unit] : spellings)
  {
    EXPECT_EQ(FindLengthUnit(name), unit) << name;
  }
}

TEST(LengthUnit, IsNotKnownOfOtherWords)
{
  // Megameters and petameters are no millimeters and picometers.
  for (const char* name : { "Mm", "Pm", "degrees_east", "pixel", "seconds", "mms", "\xB5m", " " })
  {
    EXPECT_EQ(FindLengthUnit(name), LengthUnit::Unknown) << name;
  }
}
