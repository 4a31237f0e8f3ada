// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IsovalueCategories_h
#define isosurface_IsovalueCategories_h

#include <array>
#include <string>
#include <vector>

namespace isosurface
{

/// How one isosurface is shown: a category of ParaView's color maps.
struct IsovalueCategory
{
  double Isovalue = 0;
  std::string Text; ///< in the legend
  std::array<double, 3> Color{};
  double Opacity = 1;

  bool operator==(const IsovalueCategory& other) const;
};

/// The shortest text that is read as this number, as lists of ParaView show it.
std::string FormatIsovalue(double isovalue);

/**
 * The categories of other isovalues, in their order, each of them once. Those that stay are kept as
 * they are. The new ones of a tissue look like it, in Hounsfield units. The others get, in turn, color,
 * opacity and text of those that have gone, with the new number in the text's place of the old one; then
 * colors that are not used yet. The first one of all gets `first`, if it is alone.
 */
std::vector<IsovalueCategory> FollowIsovalues(std::vector<IsovalueCategory> categories,
  const std::vector<double>& isovalues, const std::string& unit,
  const std::array<double, 3>& first);

} // namespace isosurface

#endif
