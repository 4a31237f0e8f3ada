// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CellMeasure_h
#define isosurface_CellMeasure_h

#include <cstdint>

namespace isosurface
{

/// The weights of a cell's squared differences along the axes in its squared gradient: squared
/// areas of the faces across these axes, relative to the largest face. In a grid whose axes are not
/// perpendicular, products of differences along two axes have weights, too.
struct MeasureWeights
{
  float X, Y, Z, XY, XZ, YZ, XYZ;
  float XTimesY = 0, XTimesZ = 0, YTimesZ = 0;
};

/// What MeasureCells takes and gives, row by row.
struct RowPointers
{
  const float* Values[4]; ///< rows of vertices: (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)
  std::int32_t* From;
  std::int32_t* To;
  std::int32_t* Area;
  std::int32_t* First;
  std::int32_t* Slope;
};

/**
 * Measures a row of cells. From and To are at most `bins`, and 0 for a cell with a sample that is not
 * finite.
 *
 * With u, v, w from -1/2 to 1/2, the trilinear interpolant of a cell is
 *   mean + gx u + gy v + gz w + hxy uv + hxz uw + hyz vw + k uvw,
 * its variance (gx^2 + gy^2 + gz^2) / 12 + (hxy^2 + hxz^2 + hyz^2) / 144 + k^2 / 1728, and the mean
 * square of its derivative by u gx^2 + (hxy^2 + hxz^2) / 12 + k^2 / 144. The mean product of its
 * derivatives by u and by v is gx gy + hxz hyz / 12.
 */
void MeasureCells(const RowPointers& pointers, std::int64_t cells, const MeasureWeights& weights,
  float bins, float one);

} // namespace isosurface

#endif
