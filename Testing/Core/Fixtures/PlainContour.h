// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PlainContour_h
#define isosurface_PlainContour_h

#include "Fixtures/BlocksByForce.h"
#include "Fixtures/TestBlockSource.h"
#include "Surface/Contour/MarchingCubesCases.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <type_traits>
#include <utility>
#include <vector>

namespace isosurface
{

/// The bits of a point and its normal. All NaN are the same.
using PointBits = std::array<std::uint32_t, 6>;

inline std::uint32_t BitsOf(float value)
{
  std::uint32_t bits = 0x7fc00000;
  if (!std::isnan(value))
  {
    std::memcpy(&bits, &value, sizeof(bits));
  }
  return bits;
}

/// A surface in a form that does not depend on the numbering of points: sorted triangles of global
/// ids, each beginning with its minimum, and the points by global id.
struct PlainSurface
{
  std::vector<std::array<std::int64_t, 3>> Triangles;
  std::map<std::int64_t, PointBits> Points;

  void AddTriangle(std::array<std::int64_t, 3> ids)
  {
    std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
    this->Triangles.push_back(ids);
  }
  bool operator==(const PlainSurface& other) const
  {
    return this->Triangles == other.Triangles && this->Points == other.Points;
  }
};

/**
 * The oracle: marching cubes in the simplest form, cell by cell. Computes each point again for each
 * cell. Does not use blocks, words or shared points.
 */
template <typename T>
class PlainContour
{
public:
  /// Says of a cell or a vertex whether it is there.
  using Predicate = std::function<bool(const Index3&)>;

  explicit PlainContour(
    const SampleVolume<T>& volume, Predicate isVisible = {}, Predicate isKnown = {})
    : Volume(volume)
    , IsVisible(std::move(isVisible))
    , IsKnown(std::move(isKnown))
  {
  }

  void Contour(double isovalue, std::int64_t firstId, PlainSurface& surface) const
  {
    const Index3 size = this->Volume.GetDimensions();
    VisitVertices(VertexBox{ {}, { size[0] - 1, size[1] - 1, size[2] - 1 } },
      [&](const Index3& cell)
      {
        if (!this->IsVisible || this->IsVisible(cell))
        {
          this->ContourCell(cell, isovalue, firstId, surface);
        }
      });
    std::sort(surface.Triangles.begin(), surface.Triangles.end());
  }

private:
  void ContourCell(
    const Index3& cell, double isovalue, std::int64_t firstId, PlainSurface& surface) const
  {
    unsigned cellCase = 0;
    for (int vertex = 0; vertex < 8; ++vertex)
    {
      const long double value = this->Volume.At(
        cell[0] + (vertex & 1), cell[1] + (vertex >> 1 & 1), cell[2] + (vertex >> 2));
      cellCase |= value >= static_cast<long double>(isovalue) ? 1u << vertex : 0u;
    }
    const std::uint64_t triangles = MarchingCubesCases[cellCase];
    const int corners = 3 * static_cast<int>(triangles >> 60);
    std::array<std::int64_t, 3> ids{};
    for (int corner = 0; corner < corners; ++corner)
    {
      const int edge = static_cast<int>(triangles >> (4 * corner) & 15);
      const int axis = edge / 4;
      Index3 from = cell;
      from[axis == 0 ? 1 : 0] += edge & 1;
      from[axis == 2 ? 1 : 2] += edge >> 1 & 1;
      const Index3 size = this->Volume.GetDimensions();
      const std::int64_t id =
        firstId + 3 * (from[0] + size[0] * (from[1] + size[1] * from[2])) + axis;
      surface.Points[id] = this->MakePoint(from, axis, isovalue);
      ids[static_cast<std::size_t>(corner % 3)] = id;
      if (corner % 3 == 2)
      {
        if (this->IsLeftHanded())
        {
          std::swap(ids[1], ids[2]);
        }
        surface.AddTriangle(ids);
      }
    }
  }

  // Whether the steps from vertex to vertex on x, y and z are left-handed in the world.
  bool IsLeftHanded() const
  {
    const GridGeometry& grid = this->Volume.Geometry;
    std::array<Vector3, 3> steps{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      for (std::size_t row = 0; row < 3; ++row)
      {
        steps[axis][row] = grid.Spacing[axis] * grid.Direction[3 * row + axis];
      }
    }
    return Dot(Cross(steps[0], steps[1]), steps[2]) < 0;
  }

  static double Subtract(T a, T b)
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      return static_cast<T>(a - b);
    }
    else
    {
      return static_cast<double>(static_cast<long double>(a) - static_cast<long double>(b));
    }
  }

  std::array<float, 3> Gradient(const Index3& vertex) const
  {
    const Index3 size = this->Volume.GetDimensions();
    std::array<float, 3> gradient{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      Index3 before = vertex;
      Index3 after = vertex;
      before[axis] = std::max<std::int64_t>(0, vertex[axis] - 1);
      after[axis] = std::min(size[axis] - 1, vertex[axis] + 1);
      before = !this->IsKnown || this->IsKnown(before) ? before : vertex;
      after = !this->IsKnown || this->IsKnown(after) ? after : vertex;
      const double difference = Subtract(this->Volume.At(after), this->Volume.At(before));
      gradient[axis] =
        static_cast<float>(after[axis] - before[axis] == 2 ? 0.5 * difference : difference);
    }
    return gradient;
  }

  PointBits MakePoint(const Index3& from, int axis, double isovalue) const
  {
    Index3 to = from;
    ++to[static_cast<std::size_t>(axis)];
    const T s0 = this->Volume.At(from);
    const T s1 = this->Volume.At(to);
    double t = (isovalue - static_cast<double>(s0)) / Subtract(s1, s0);
    if (!std::is_floating_point_v<T> && sizeof(T) == 8)
    {
      t = std::min(1.0, std::max(0.0, t));
    }
    const GridGeometry& geometry = this->Volume.Geometry;
    std::array<float, 3> index{};
    for (std::size_t n = 0; n < 3; ++n)
    {
      index[n] = static_cast<float>(static_cast<double>(from[n]) +
        t * static_cast<double>(to[n] - from[n]) + static_cast<double>(geometry.Extent[2 * n]));
    }
    const std::array<float, 3> g0 = this->Gradient(from);
    const std::array<float, 3> g1 = this->Gradient(to);
    std::array<float, 3> normal{};
    for (std::size_t n = 0; n < 3; ++n)
    {
      normal[n] = -static_cast<float>(g0[n] + t * (g1[n] - g0[n]));
    }
    const float length =
      std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    PointBits bits{};
    for (std::size_t n = 0; n < 3; ++n)
    {
      double world = geometry.Origin[n];
      if (geometry == this->Placed())
      {
        world = static_cast<double>(index[n]) + geometry.Origin[n];
      }
      else
      {
        const auto* row = &geometry.Direction[3 * n];
        world = row[0] * geometry.Spacing[0] * index[0] + row[1] * geometry.Spacing[1] * index[1] +
          row[2] * geometry.Spacing[2] * index[2] + geometry.Origin[n];
      }
      bits[n] = BitsOf(static_cast<float>(world));
      bits[3 + n] = BitsOf(length != 0 ? normal[n] / length : normal[n]);
    }
    return bits;
  }

  // The same grid without spacing and direction.
  GridGeometry Placed() const
  {
    GridGeometry plain;
    plain.Extent = this->Volume.Geometry.Extent;
    plain.Origin = this->Volume.Geometry.Origin;
    return plain;
  }

  const SampleVolume<T>& Volume;
  Predicate IsVisible; ///< of cells; all, if empty
  Predicate IsKnown;   ///< of vertices whose samples gradients are made of; all, if empty
};

template <typename T>
PlainSurface ContourPlainly(const SampleVolume<T>& volume, const std::vector<double>& isovalues)
{
  PlainSurface surface;
  for (std::size_t n = 0; n < isovalues.size(); ++n)
  {
    PlainContour<T>(volume).Contour(isovalues[n],
      static_cast<std::int64_t>(n) * 3 * volume.Geometry.GetNumberOfVertices(), surface);
  }
  return surface;
}

/// Converts an extracted surface, which must have global ids. It need not have normals.
inline PlainSurface MakePlain(const Surface& surface)
{
  PlainSurface plain;
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    PointBits bits{};
    for (std::size_t n = 0; n < 3; ++n)
    {
      bits[n] = BitsOf(surface.Points[3 * point + n]);
      bits[3 + n] = surface.Normals.IsEmpty() ? 0 : BitsOf(surface.Normals[3 * point + n]);
    }
    plain.Points[surface.GlobalIds[point]] = bits;
  }
  for (std::size_t triangle = 0; triangle < surface.NumberOfTriangles; ++triangle)
  {
    std::array<std::int64_t, 3> ids{};
    for (std::size_t n = 0; n < 3; ++n)
    {
      ids[n] = surface.GlobalIds[static_cast<std::size_t>(surface.Connectivity[3 * triangle + n])];
    }
    plain.AddTriangle(ids);
  }
  std::sort(plain.Triangles.begin(), plain.Triangles.end());
  return plain;
}

/// For a surface with all that the oracle has.
inline ContourRequest MakePlainRequest(std::vector<double> isovalues)
{
  ContourRequest request;
  request.Isovalues = std::move(isovalues);
  request.Normals = true;
  request.GlobalIds = true;
  return request;
}

/// The surface of all blocks of a volume.
template <typename T>
Surface ExtractBlocks(const SampleVolume<T>& volume, int blockSize, const ContourRequest& request,
  int threads = 1, int components = 1)
{
  TestBlockSource<T> source(volume, blockSize, 1, components);
  return Require(ExtractSurface(volume.Geometry, source, request, threads));
}

/// The surfaces of ranks to which blocks were dealt at random, in random order.
template <typename T>
std::vector<PlainSurface> ExtractPieces(const SampleVolume<T>& volume, int blockSize,
  const ContourRequest& request, std::vector<std::int64_t> blocks, int ranks, std::mt19937& random)
{
  std::shuffle(blocks.begin(), blocks.end(), random);
  std::vector<std::vector<std::int64_t>> pieces(static_cast<std::size_t>(ranks));
  for (const std::int64_t block : blocks)
  {
    pieces[random() % pieces.size()].push_back(block);
  }
  std::vector<PlainSurface> surfaces;
  for (const auto& piece : pieces)
  {
    TestBlockSource<T> source(volume, blockSize);
    source.Blocks = piece;
    const Surface surface = Require(ExtractSurface(volume.Geometry, source, request, 2));
    surfaces.push_back(MakePlain(surface));
    EXPECT_EQ(surfaces.back().Points.size(), surface.NumberOfPoints) << "a point is there twice";
  }
  return surfaces;
}

/// The union of the surfaces of several ranks. Points with equal ids must be equal.
inline PlainSurface UniteRanks(const std::vector<PlainSurface>& ranks)
{
  PlainSurface united;
  for (const PlainSurface& rank : ranks)
  {
    united.Triangles.insert(united.Triangles.end(), rank.Triangles.begin(), rank.Triangles.end());
    for (const auto& [id, bits] : rank.Points)
    {
      EXPECT_EQ(united.Points.emplace(id, bits).first->second, bits)
        << "two ranks disagree on point " << id;
    }
  }
  std::sort(united.Triangles.begin(), united.Triangles.end());
  return united;
}

/// Expects parts one behind the other, and no point that no cell uses.
inline void ExpectWholeParts(const Surface& surface)
{
  std::size_t points = 0;
  std::size_t cells = 0;
  for (const SurfacePart& part : surface.Parts)
  {
    EXPECT_EQ(part.FirstPoint, points);
    EXPECT_EQ(part.FirstCell, cells);
    points += part.NumberOfPoints;
    cells += part.NumberOfCells;
  }
  EXPECT_EQ(points, surface.NumberOfPoints);
  EXPECT_EQ(cells, surface.NumberOfCells);
  std::vector<bool> used(surface.NumberOfPoints, false);
  for (std::size_t n = 0; n < surface.Connectivity.GetSize(); ++n)
  {
    used.at(static_cast<std::size_t>(surface.Connectivity[n])) = true;
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << "points that no cell uses";
}

template <typename T>
bool AreSame(const Buffer<T>& a, const Buffer<T>& b)
{
  return a.GetSize() == b.GetSize() &&
    (a.GetSize() == 0 || std::memcmp(a.GetData(), b.GetData(), a.GetSize() * sizeof(T)) == 0);
}

inline bool AreSame(const IndexArray& a, const IndexArray& b)
{
  return a.Is64Bit == b.Is64Bit && AreSame(a.Values32, b.Values32) &&
    AreSame(a.Values64, b.Values64);
}

/// Expects two surfaces to be equal bit by bit.
inline void ExpectSameSurface(const Surface& surface, const Surface& expected)
{
  EXPECT_TRUE(AreSame(surface.Points, expected.Points));
  EXPECT_TRUE(AreSame(surface.Normals, expected.Normals));
  EXPECT_TRUE(AreSame(surface.GlobalIds, expected.GlobalIds));
  EXPECT_TRUE(AreSame(surface.Connectivity, expected.Connectivity));
  EXPECT_TRUE(AreSame(surface.Offsets, expected.Offsets));
  EXPECT_EQ(surface.NumberOfPoints, expected.NumberOfPoints);
  EXPECT_EQ(surface.NumberOfCells, expected.NumberOfCells);
  EXPECT_EQ(surface.NumberOfTriangles, expected.NumberOfTriangles);
  EXPECT_EQ(surface.NumberOfBlocks, expected.NumberOfBlocks);
  ASSERT_EQ(surface.Attributes.size(), expected.Attributes.size());
  for (std::size_t n = 0; n < expected.Attributes.size(); ++n)
  {
    EXPECT_TRUE(AreSame(surface.Attributes[n].Bytes, expected.Attributes[n].Bytes));
  }
  ASSERT_EQ(surface.Parts.size(), expected.Parts.size());
  for (std::size_t n = 0; n < expected.Parts.size(); ++n)
  {
    EXPECT_EQ(surface.Parts[n].FirstPoint, expected.Parts[n].FirstPoint);
    EXPECT_EQ(surface.Parts[n].NumberOfCells, expected.Parts[n].NumberOfCells);
  }
}

} // namespace isosurface

#endif
