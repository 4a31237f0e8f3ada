// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MarchingCubesCases_h
#define isosurface_MarchingCubesCases_h

#include <cstdint>

namespace isosurface
{

/**
 * The 256 cases of marching cubes (W. E. Lorensen, H. E. Cline, "Marching cubes: A high resolution
 * 3D surface construction algorithm", SIGGRAPH 1987), with the same triangles in the same order as
 * vtkMarchingCubesTriangleCases. On a face, the cases of both cells agree.
 *
 * Vertices of a cell: vertex x + 2y + 4z is the corner (x, y, z). Bit v of a case is set if vertex
 * v is inside.
 *
 * Edges of a cell, by axis: 0-3 along x from (0, y, z), number y + 2z; 4-7 along y from (x, 0, z),
 * number 4 + x + 2z; 8-11 along z from (x, y, 0), number 8 + x + 2y.
 *
 * A case is one word: nibble n, from the lowest, is the edge of corner n % 3 of triangle n / 3; the
 * top nibble is the number of triangles, at most 5.
 */
extern const std::uint64_t MarchingCubesCases[256];

/**
 * A case as polygons: one for each loop in which the surface crosses the cell's faces, with the
 * orientation of the triangles. Derived from MarchingCubesCases: the outlines of connected
 * triangles.
 */
struct PolygonCase
{
  std::uint8_t NumberOfPolygons = 0;
  std::uint8_t NumberOfCorners = 0; ///< of all polygons: the crossed edges of the cell
  std::uint8_t Sizes[4] = {};       ///< corners of each polygon
  std::uint8_t Corners[12] = {};    ///< cell edges, polygon after polygon
};

/// The 256 cases as triangles, in the form of MarchingCubesCases, and as polygons.
struct CellCases
{
  const std::uint64_t* Triangles;
  const PolygonCase* Polygons;
};

/**
 * The cases with the corners in the order in which they run counter-clockwise in the world, seen from
 * low values. In a left-handed grid that is the other way round (`areTurned`, IsLeftHanded): the second and the third
 * corner of each triangle change places. Made on first use.
 */
CellCases GetCellCases(bool areTurned);

} // namespace isosurface

#endif
