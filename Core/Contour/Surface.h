// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Surface_h
#define isosurface_Surface_h

#include "Base/Buffer.h"
#include "Volume/GridSides.h"
#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The type and width of a point attribute that is interpolated along with the surface.
struct AttributeLayout
{
  ValueType Type = ValueType::Float32;
  int NumberOfComponents = 1;
};

/// The type that values of an attribute have on the surface, as in vtkFlyingEdges3D: float32, but
/// for float64, which stays.
inline ValueType GetInterpolatedType(ValueType type)
{
  return type == ValueType::Float64 ? type : ValueType::Float32;
}

/// What to extract.
struct ContourRequest
{
  /// In the order of the output. A value that is NaN or above all values of the type has no
  /// surface.
  std::vector<double> Isovalues;
  bool Normals = false;   ///< fill Surface::Normals: unit vectors from high to low values
  bool GlobalIds = false; ///< fill Surface::GlobalIds
  /// One polygon for each loop in which the surface cuts a cell, instead of triangles.
  bool Polygons = false;
  /// Fill Surface::Offsets for triangles, too (for polygons they are always there).
  bool Offsets = false;
  /// Make points at one vertex of the grid one, and leave out the triangles that collapse thereby.
  /// Without effect on polygons. See ExtractSurface.
  bool DropDegenerateTriangles = false;
  /// Close the surface at these sides of the grid, as if all were outside beyond them.
  GridSides ClosedSides;
  /// Indices of 64 bits even where 32 suffice.
  bool WideIndices = false;
  /// Interpolate these: the arrays that the source gives in BlockSamples::Attributes, in order.
  std::vector<AttributeLayout> Attributes;
};

/// Integers of 32 bits where they suffice, else of 64 bits: one of the two buffers is in use.
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

/// The part of a surface that belongs to one isovalue. Parts follow each other without gaps.
struct SurfacePart
{
  double Isovalue = 0;
  std::size_t FirstPoint = 0;
  std::size_t NumberOfPoints = 0;
  std::size_t FirstCell = 0;
  std::size_t NumberOfCells = 0;
};

/**
 * A surface of triangles (or polygons) that share their points. Every array is written once, in
 * its final place; Buffer::Release hands it to a VTK array without a copy.
 */
struct Surface
{
  Buffer<float> Points;           ///< x, y, z in the world
  Buffer<float> Normals;          ///< x, y, z of unit length, (0, 0, 0) where there is no gradient
  Buffer<std::int64_t> GlobalIds; ///< see ExtractSurface
  IndexArray Connectivity;        ///< point numbers, cell after cell
  IndexArray
    Offsets; ///< cells + 1 values into Connectivity, of the same width; empty if not asked for
  std::vector<SurfaceAttribute> Attributes;
  std::vector<SurfacePart> Parts; ///< one an isovalue, in the order of the request

  std::size_t NumberOfPoints = 0;
  std::size_t NumberOfCells = 0;     ///< triangles or polygons
  std::size_t NumberOfTriangles = 0; ///< that the cells have when cut into triangles
  std::size_t NumberOfBlocks = 0;    ///< blocks that were acquired
  double AcquireSeconds = 0;         ///< in BlockSource::Acquire, summed over the threads
  double TotalSeconds = 0;           ///< wall clock of the whole call
};

} // namespace isosurface

#endif
