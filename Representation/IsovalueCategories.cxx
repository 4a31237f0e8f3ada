// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "IsovalueCategories.h"

#include "Tissues.h"

#include "vtkMath.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

namespace isosurface
{
namespace
{

using Color = std::array<double, 3>;

// Colors that color-blind people tell apart, without black: Masataka Okabe, Kei Ito, Color Universal
// Design, 2008.
constexpr std::array<Color, 7> Palette = { { { 0.90, 0.60, 0.00 }, { 0.35, 0.70, 0.90 },
  { 0.00, 0.60, 0.50 }, { 0.95, 0.90, 0.25 }, { 0.00, 0.45, 0.70 }, { 0.80, 0.40, 0.00 },
  { 0.80, 0.60, 0.70 } } };

Color MakeColor(std::size_t number)
{
  if (number < Palette.size())
  {
    return Palette[number];
  }
  // Hues a golden section apart are all different.
  constexpr double section = 0.6180339887498949;
  Color color{ std::fmod(section * static_cast<double>(number), 1.0), 0.55, 0.9 };
  vtkMath::HSVToRGB(color.data(), color.data());
  return color;
}

Color FindUnusedColor(const std::vector<IsovalueCategory>& used)
{
  for (std::size_t number = 0;; ++number)
  {
    const Color color = MakeColor(number);
    if (std::none_of(used.begin(), used.end(),
          [&color](const IsovalueCategory& category) { return category.Color == color; }))
    {
      return color;
    }
  }
}

std::vector<IsovalueCategory>::iterator Find(
  std::vector<IsovalueCategory>& categories, double isovalue)
{
  return std::find_if(categories.begin(), categories.end(),
    [isovalue](const IsovalueCategory& category) { return category.Isovalue == isovalue; });
}

const Tissue* FindTissue(double isovalue, const std::string& unit)
{
  const auto* tissue = std::find_if(Tissues.begin(), Tissues.end(),
    [isovalue](const Tissue& any) { return any.Isovalue == isovalue; });
  return tissue != Tissues.end() && AreTissuesIn(unit.c_str()) ? &*tissue : nullptr;
}

std::string Describe(double isovalue, const std::string& unit)
{
  return FormatIsovalue(isovalue) + (unit.empty() ? "" : " " + unit);
}

} // namespace

bool IsovalueCategory::operator==(const IsovalueCategory& other) const
{
  return this->Isovalue == other.Isovalue && this->Text == other.Text &&
    this->Color == other.Color && this->Opacity == other.Opacity;
}

std::string FormatIsovalue(double isovalue)
{
  const double magnitude = std::abs(isovalue);
  const bool isPlain = magnitude == 0 || (magnitude >= 1e-6 && magnitude < 1e21);
  std::array<char, 64> text{};
  const std::to_chars_result end = std::to_chars(text.data(), text.data() + text.size(), isovalue,
    isPlain ? std::chars_format::fixed : std::chars_format::scientific);
  return std::string(text.data(), end.ptr);
}

std::vector<IsovalueCategory> FollowIsovalues(std::vector<IsovalueCategory> categories,
  const std::vector<double>& isovalues, const std::string& unit, const std::array<double, 3>& first)
{
  const bool isFirst = categories.empty();
  std::vector<IsovalueCategory> followed;
  std::vector<std::size_t> added;
  for (const double isovalue : isovalues)
  {
    if (Find(followed, isovalue) != followed.end())
    {
      continue;
    }
    const auto known = Find(categories, isovalue);
    if (known != categories.end())
    {
      followed.push_back(std::move(*known));
      categories.erase(known);
    }
    else if (const Tissue* tissue = FindTissue(isovalue, unit))
    {
      followed.push_back({ isovalue, std::string(tissue->Name) + ", " + Describe(isovalue, unit),
        tissue->Color, tissue->Opacity });
    }
    else
    {
      added.push_back(followed.size());
      followed.push_back({ isovalue, Describe(isovalue, unit) });
    }
  }
  auto gone = categories.begin();
  for (const std::size_t place : added)
  {
    IsovalueCategory& category = followed[place];
    if (gone != categories.end())
    {
      category.Color = gone->Color;
      category.Opacity = gone->Opacity;
      const std::string number = FormatIsovalue(gone->Isovalue);
      const std::size_t at = gone->Text.rfind(number);
      category.Text = at == std::string::npos
        ? gone->Text
        : std::string(gone->Text).replace(at, number.size(), FormatIsovalue(category.Isovalue));
      ++gone;
    }
    else
    {
      category.Color = isFirst && followed.size() == 1 ? first : FindUnusedColor(followed);
    }
  }
  return followed;
}

} // namespace isosurface
