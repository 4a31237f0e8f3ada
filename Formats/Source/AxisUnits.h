// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AxisUnits_h
#define isosurface_AxisUnits_h

#include "Ground/Volume/GridGeometry.h"

#include <array>
#include <string>

namespace isosurface
{

/// Adds a sentence to what is told of a file (OpenedVolume::LeftOut).
void AddNote(std::string& told, const std::string& note);

/**
 * Gives a grid, whose axes are those of the world, the unit of length of x, y and z, as a file names
 * them. If they differ, spacing and origin of y and z are converted to the unit of x. What is no unit of
 * length is told, and so is a unit of some axes alone; names that are empty are not known.
 */
void TakeLengthUnits(
  const std::array<std::string, 3>& names, GridGeometry& grid, std::string& told);

} // namespace isosurface

#endif
