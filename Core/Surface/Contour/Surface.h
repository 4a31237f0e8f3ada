// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Surface_h
#define isosurface_Surface_h

#include "Ground/Base/Buffer.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/GridSides.h"
#include "Ground/Volume/PointPrecision.h"
#include "Ground/Volume/ValueType.h"
#include "Ground/Volume/Vector3.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace isosurface
{

/// The type and width of a point attribute that is interpolated along with the surface.
struct AttributeLayout
{
  ValueType Type = ValueType::Float32;
  int NumberOfComponents = 1;
};

/// The type of an attribute's values on the surface, as in vtkFlyingEdges3D: float64 stays, all
/// others become float32.
inline ValueType GetInterpolatedType(ValueType type)
{
  return type == ValueType::Float64 ? type : ValueType::Float32;
}

/// The bytes of an interpolated tuple.
inline std::size_t GetTupleSize(const AttributeLayout& layout)
{
  return static_cast<std::size_t>(layout.NumberOfComponents) *
    GetValueSize(GetInterpolatedType(layout.Type));
}

/// What to extract.
struct ContourRequest
{
  /// In the order of the output. There is no surface for NaN, or above all values of the type.
  std::vector<double> Isovalues;
  PointPrecision Precision = PointPrecision::Default;
  bool Normals = false; ///< fill Surface::Normals: unit vectors from high to low values
  /// Round normals to float once, at the end, as vtkImageTransform does since VTK 9.4. Otherwise
  /// after each step of their transformation, as it did before.
  bool NormalsRoundedOnce = false;
  /// Turn normals by the grid's direction, as vtkImageTransform did before VTK 9.2. Otherwise by
  /// the transposed inverse of it, as it does since: the same but for the last bits and signs of
  /// zeros.
  bool NormalsByDirection = false;
  bool GlobalIds = false; ///< fill Surface::GlobalIds
  /// Make one polygon for each loop of the surface in a cell, instead of triangles.
  bool Polygons = false;
  /// Fill Surface::Offsets for triangles, too. For polygons they are always filled.
  bool Offsets = false;
  /**
   * Merge points whose structured coordinates, as floats (of float64 points: as doubles), are those of
   * the same vertex of the grid,
   * and drop triangles with two corners there, then points without triangles. The merged point has
   * the gradient and the attributes at the vertex. Other triangles do not change, so a closed
   * surface stays closed. It stays a manifold where the inside is thicker than a vertex; sheets
   * that touch at a vertex are joined. No effect on polygons.
   *
   * Global id of a merged point: (3 * number of isovalues + isovalue number) * NumberOfVertices +
   * vertex, above the ids of all edges. The id of an edge would be ambiguous: if the sample is only
   * near the isovalue, the edge may also have a point of its own.
   */
  bool DropDegenerateTriangles = false;
  /**
   * Close the surface at these sides of the grid: the surface is that of a grid with one more layer
   * at these sides, which is outside, with the points in the layer moved onto the side. The caps
   * lie exactly in the sides, with outward normals. Where two caps meet, each has its own point,
   * and triangles without area connect them. Points where the isosurface meets a cap have the
   * normals of the isosurface. (With DropDegenerateTriangles, a vertex on the sides has one point,
   * with the mean of the sides' outward normals.) A grid of one vertex on an axis has no surface.
   *
   * With GridSides::AreBeyondInside the layer is inside, and the closed surface bounds the outside:
   * corners of triangles run the other way round, and normals point to high values.
   *
   * Besides the active blocks, the source must give the blocks at these sides that are entirely
   * inside, or outside: see BlockSelection.
   */
  GridSides ClosedSides;
  /// The vertices of the grid whose samples are known, if these are not all: at the faces of this
  /// box gradients are one-sided differences, as they are at the faces of the grid.
  std::optional<VertexBox> KnownSamples;
  /// Leave out the cells with a corner that is NaN. If not, NaN is outside, and the surface has a
  /// wall there, whose points are NaN. Hidden cells (BlockSamples::Hidden) are always left out.
  /// Such samples have no influence on normals: differences are one-sided beside them.
  bool SkipNotANumber = false;
  /// If given, the vertices of the grid lie at these lines, whatever its origin, spacing and
  /// direction, which must be those of structured coordinates. Must outlive the extraction.
  const GridLines* Lines = nullptr;
  /// Use indices of 64 bits even if 32 suffice.
  bool WideIndices = false;
  /// The arrays to interpolate, in the order of BlockSamples::Attributes.
  std::vector<AttributeLayout> Attributes;
};

/// Whether a surface of `points` points, and `corners` corners of all its cells, needs indices of 64
/// bits. Connectivity and offsets then both have 64 bits, as vtkCellArray wants it.
constexpr bool NeedsWideIndices(std::size_t points, std::size_t corners)
{
  constexpr std::size_t maximum = std::numeric_limits<std::int32_t>::max();
  return points > maximum || corners > maximum;
}

/// Integers of 32 bits if these suffice, otherwise of 64 bits. One of the two buffers is used.
struct IndexArray
{
  bool Is64Bit = false;
  Buffer<std::int32_t> Values32;
  Buffer<std::int64_t> Values64;

  std::size_t GetSize() const
  {
    return this->Is64Bit ? this->Values64.GetSize() : this->Values32.GetSize();
  }
  std::int64_t operator[](std::size_t index) const
  {
    return this->Is64Bit ? this->Values64[index] : this->Values32[index];
  }
};

/// One interpolated attribute: tuples in the order of the points, of the interpolated type.
struct SurfaceAttribute
{
  AttributeLayout Layout;
  Buffer<std::uint8_t> Bytes; ///< points * components values of Layout.Type
};

/// The part of a surface for one isovalue. The parts are contiguous.
struct SurfacePart
{
  double Isovalue = 0;
  std::size_t FirstPoint = 0;
  std::size_t NumberOfPoints = 0;
  std::size_t FirstCell = 0;
  std::size_t NumberOfCells = 0;
};

/**
 * A surface of triangles (or polygons) that share their points. Buffer::Release() can hand its
 * arrays to VTK arrays without a copy.
 */
struct Surface
{
  Buffer<float> Points;           ///< x, y, z in the world; empty if they are float64
  Buffer<double> DoublePoints;    ///< in place of Points
  bool HasDoublePoints = false;   ///< also tells the type of no points
  Buffer<float> Normals;          ///< x, y, z of unit length, (0, 0, 0) where there is no gradient
  Buffer<std::int64_t> GlobalIds; ///< see ExtractSurface
  IndexArray Connectivity;        ///< point numbers, cell after cell
  IndexArray
    Offsets; ///< cells + 1 values into Connectivity, of the same width; empty unless requested
  std::vector<SurfaceAttribute> Attributes;
  std::vector<SurfacePart> Parts; ///< one for each isovalue, in the order of the request

  Vector3 GetPoint(std::size_t point) const
  {
    const auto get = [point](const auto& points) -> Vector3 {
      return { points[3 * point], points[3 * point + 1], points[3 * point + 2] };
    };
    return this->HasDoublePoints ? get(this->DoublePoints) : get(this->Points);
  }

  std::size_t NumberOfPoints = 0;
  std::size_t NumberOfCells = 0;     ///< triangles or polygons
  std::size_t NumberOfTriangles = 0; ///< polygons count as the triangles that they consist of
  std::size_t NumberOfBlocks = 0;    ///< blocks that were acquired
  double AcquireSeconds = 0;         ///< in BlockSource::Acquire(), summed over the threads
  double TotalSeconds = 0;           ///< wall clock of the whole call
};

} // namespace isosurface

#endif
