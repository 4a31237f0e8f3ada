// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointPrecision_h
#define isosurface_PointPrecision_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"

#include <cstdint>

namespace isosurface
{

/// The type of points, as vtkContourFilter's OutputPointsPrecision has it.
enum class PointPrecision : std::uint8_t
{
  Default, ///< Double where NeedsDoublePoints, else Single
  Single,  ///< float32
  Double   ///< float64
};

/**
 * Whether float32 has fewer than 16 places between some neighbouring vertices of a grid, so that its
 * points need float64. What counts is how far float32 numbers lie apart at the largest coordinates of
 * the grid: seen along each of its axes, that must be at most 1/16 of the spacing. In a grid that is
 * turned, the distances on the world's axes add up. So must those of structured coordinates, which are
 * fine below 2^20. On lines each pair of neighbours is looked at.
 */
bool NeedsDoublePoints(const GridGeometry& grid, const GridLines* lines);

} // namespace isosurface

#endif
