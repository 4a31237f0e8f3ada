// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeSurface_h
#define isosurface_EdgeSurface_h

#include "vtkSmartPointer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

class vtkImageData;
class vtkPolyData;

namespace isosurface
{

/// A point of an isosurface. Floats are kept as their bits; all NaNs have the same.
struct EdgePoint
{
  std::int64_t Edge = 0; ///< grid edge: 3 * vertex + axis
  std::array<std::uint32_t, 3> Position{};
  std::array<std::uint32_t, 3> Normal{}; ///< 0 if there are none

  bool operator==(const EdgePoint& other) const;
  bool operator<(const EdgePoint& other) const;
};

/**
 * A surface of triangles told by the grid edges that its points lie on, so that neither the order
 * of points nor that of triangles matters: two surfaces are the same if their EdgeSurfaces are
 * equal, bit for bit.
 */
struct EdgeSurface
{
  using Triangle = std::array<std::int64_t, 3>; ///< edges, rotated: the smallest one first

  std::vector<EdgePoint> Points;   ///< ascending
  std::vector<Triangle> Triangles; ///< ascending

  /// Adds the triangles of a vtkStabbingContour's output, or those of one of its isovalues: with
  /// GlobalIds from firstId up to, but not including, endId. Ids are then counted from firstId.
  void Add(vtkPolyData* contour, std::int64_t firstId = 0, std::int64_t endId = INT64_MAX);

  /// Makes bitwise equal points one: what merging by GlobalIds does to several outputs.
  void MergeEqualPoints();

  /// Forgets the normals, to compare points and triangles alone.
  void DropNormals();

  /// Zeros in normals become positive.
  void DropSignsOfZeros();

  /// A zero gradient has no direction: its normal, of zeros with any signs, becomes (0, 0, 0). On a
  /// grid that is turned, vtkFlyingEdges3D has NaN instead: `isNan` if such normals are zero, too.
  void ClearZeroNormals(bool isNan);
};

/// What vtkFlyingEdges3D makes, without scalars.
vtkSmartPointer<vtkPolyData> RunFlyingEdges(vtkImageData* image, double isovalue, bool normals);

/**
 * The surface as vtkFlyingEdges3D has it, but in a left-handed grid with the corners turned, and with
 * normals reversed where the direction is mirrored, so that both point to low values. The grid edge of each of its points is found by
 * contouring, in the same way, a copy of the image with samples of 0 (outside) and 1 (inside) on a
 * unit grid: vtkFlyingEdges3D orders points by inside and outside alone, and those of the copy lie
 * in the middle of their edges.
 */
EdgeSurface ContourByFlyingEdges(vtkImageData* image, double isovalue);

/// Success, or the first differences.
testing::AssertionResult AreEqual(const EdgeSurface& surface, const EdgeSurface& expected);

/// Whether each side of a triangle is there as often in one direction as in the other.
bool IsClosed(const EdgeSurface& surface);

/// Whether every side of a triangle is the side of exactly one other triangle, the other way round.
testing::AssertionResult IsClosedManifold(const EdgeSurface& surface);

} // namespace isosurface

#endif
