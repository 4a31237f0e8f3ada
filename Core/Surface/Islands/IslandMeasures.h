// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandMeasures_h
#define isosurface_IslandMeasures_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Surface/Contour/Surface.h"
#include "Surface/Islands/IslandLabels.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace isosurface
{

/// What triangles of some grids can be: bounds that all ranks know without their surfaces.
struct TriangleBounds
{
  double Area = 0; ///< of a triangle, at most
  double LowZ = 0; ///< of a point
  double HighZ = 0;

  /// Those of the cells of a grid, which lies on lines if there are any.
  static TriangleBounds Of(const GridGeometry& grid, const GridLines* lines);
  void Extend(const TriangleBounds& other);
};

/**
 * Areas and volumes as whole numbers of a unit, so that their sums do not depend on the order: not
 * on threads, blocks or ranks. The units are powers of two, the finest with which the sums over all
 * triangles of all ranks fit into 62 bits. With a million triangles that is a rounding of 2^-42 of
 * the largest triangle in each.
 */
struct IslandUnits
{
  double Area = 1;   ///< in the world
  double Volume = 1; ///< in the world
  double MiddleZ = 0;
  double MaximumArea = 0;
  double MaximumVolume = 0; ///< of the prism between a triangle and the plane z = MiddleZ

  IslandUnits() = default;
  /// `triangles`: of all ranks.
  IslandUnits(const TriangleBounds& bounds, std::uint64_t triangles);
};

/// The sums over the triangles of an island.
struct IslandMeasure
{
  std::uint64_t Triangles = 0; ///< polygons count as the triangles that they consist of
  std::int64_t Area = 0;       ///< in IslandUnits::Area
  /// Between the island and a plane, in IslandUnits::Volume. Its magnitude is the volume that the
  /// island encloses, if it is closed.
  std::int64_t Volume = 0;
  /// The minimum of the global ids of its points, which tells islands apart.
  std::int64_t FirstId = std::numeric_limits<std::int64_t>::max();

  void Add(const IslandMeasure& other);
};

/// The islands of one rank's surface, which has GlobalIds, in the order of their numbers. Points
/// that are NaN give their triangles no area. Memory meanwhile: 64 bytes an island.
std::vector<IslandMeasure> MeasureIslands(
  const Surface& surface, const IslandLabels& labels, const IslandUnits& units, int threads);

/// The point of an island that is nearest to a given one.
struct NearestIsland
{
  double SquaredDistance = std::numeric_limits<double>::infinity();
  std::int64_t FirstId = std::numeric_limits<std::int64_t>::max();

  /// At the same distance, that with the lower id.
  bool IsNearerThan(const NearestIsland& other) const;
};

/// Of the islands that are kept. The distance is that to the nearest point of a triangle.
NearestIsland FindNearestIsland(const Surface& surface, const IslandLabels& labels,
  const std::vector<IslandMeasure>& measures, const std::vector<std::uint8_t>& areKept,
  const std::array<double, 3>& place, int threads);

} // namespace isosurface

#endif
