// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PlaneLattice_h
#define isosurface_PlaneLattice_h

#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Storage/Sampling/PointSampling.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace isosurface
{

/// A plane in world coordinates. The normal has any length but 0.
struct Plane
{
  std::array<double, 3> Origin{ 0, 0, 0 };
  std::array<double, 3> Normal{ 0, 0, 1 };
};

/**
 * The points at which a plane shows the samples of a grid: an image of one slice, as large as the
 * part of the plane within the grid.
 *
 * A plane along two axes of a regular grid has the grid's own vertices on these axes: in the order
 * y z, x z or x y, at the plane's place on the third axis. Any other plane has square cells of the
 * smallest spacing of the grid. Its first axis is that of the grid that is the least steep to the
 * plane, projected; the second is perpendicular to it. The corners of such an image may lie beyond
 * the grid.
 */
class PlaneLattice
{
public:
  /// More points than any image has.
  static constexpr double Unlimited = 1e12;

  /// Nothing if the plane has no point of the grid, or if the grid has no vertices. `lines`: of a
  /// rectilinear grid. `maximumPoints`, more than 1: a plane that would have more points has larger
  /// square cells, and is not aligned.
  static std::optional<PlaneLattice> Make(const GridGeometry& grid, const GridLines* lines,
    const Plane& plane, double maximumPoints = Unlimited);

  /// The image's geometry, with an extent of one vertex on the third axis.
  const GridGeometry& GetImage() const { return this->Image; }

  /// Whether the plane is along two axes of a regular grid: then no point is beyond the grid.
  bool IsAligned() const { return this->Axis.has_value(); }
  double CountPoints() const;
  /**
   * Fills `values` with one variable at the points of a part of the image, whose vertices are
   * counted from 0, x fastest; `isInside` (may be null) tells which points are within the grid, as
   * SamplePoints does. The samples must be those of the grid. Reads each block that the plane
   * crosses once, or, if the plane is not aligned, once for each tile of 64 x 64 points, through the
   * block cache. Errors: as SamplePoints.
   */
  Status Sample(const LevelSamples& samples, std::size_t variable, Interpolation interpolation,
    const VertexBox& part, int threads, void* values, std::ptrdiff_t stride, std::uint8_t* isInside,
    QueryStatistics& statistics, const Progress& progress = {}) const;

  /// The points of a part of the image, in tiles; `part` counts the image's vertices from 0. Values
  /// are numbered within the part, x fastest. The lattice must outlive what is returned.
  PointPortions MakePortions(const VertexBox& part) const;

private:
  explicit PlaneLattice(const VertexPlaces& places)
    : Places(places)
    , ImagePlaces(GridGeometry())
  {
  }
  /// Takes the grid's vertices on the axes but one, at the place of a point on that one.
  void AlignTo(const GridGeometry& grid, std::size_t axis, const std::array<double, 3>& point);
  /// Covers points of the plane; the axes have length 1.
  void Cover(const std::vector<std::array<double, 3>>& points,
    const std::array<std::array<double, 3>, 3>& axes, double spacing, double maximumPoints);
  std::array<double, 3> FindVertex(const Index3& imageVertex) const;
  /// Of an aligned plane: the axis of the grid that is the first (0) or second (1) of the image.
  std::size_t GetImageAxis(std::size_t number) const
  {
    return number < *this->Axis ? number : number + 1;
  }
  Status SampleAligned(const LevelSamples& samples, std::size_t variable,
    Interpolation interpolation, const VertexBox& part, int threads, void* values,
    std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress) const;

  VertexPlaces Places;
  VertexPlaces ImagePlaces; ///< unless the plane is aligned
  GridGeometry Image;
  std::optional<std::size_t> Axis; ///< of the grid, to which an aligned plane is perpendicular
  double Vertex = 0;               ///< the vertex coordinate of an aligned plane on that axis
};

/// The lattice of a level of a volume.
struct LevelLattice
{
  int Level = 0;
  PlaneLattice Lattice;
};

/**
 * The lattice of the finest level, from a first one on, at which the lattice has at most
 * `maximumPoints`. If it has more points at every level, its cells become larger.
 *
 * The last vertices of a coarse level may lie before the plane. Then a plane along two axes is that
 * of the last vertices; any other one stays at the coarsest level that it meets. Nothing if the
 * plane does not meet the first level, or if level 0 has no lattice.
 */
std::optional<LevelLattice> FindLatticeWithin(
  const BlockedVolume& volume, const Plane& plane, double maximumPoints, int firstLevel = 0);

} // namespace isosurface

#endif
