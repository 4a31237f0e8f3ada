// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/MarchingCubesCases.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

using Triangle = std::array<int, 3>;
using Side = std::pair<int, int>;

std::vector<Triangle> TrianglesOf(unsigned cellCase)
{
  const std::uint64_t word = MarchingCubesCases[cellCase];
  std::vector<Triangle> triangles(word >> 60);
  for (std::size_t n = 0; n < 3 * triangles.size(); ++n)
  {
    triangles[n / 3][n % 3] = static_cast<int>(word >> (4 * n) & 15);
  }
  return triangles;
}

// The two vertices of a cell edge, numbered as in the header.
Side VerticesOf(int edge)
{
  const int axis = edge / 4;
  const int lower = edge & 1;
  const int upper = edge >> 1 & 1;
  const int from = axis == 0 ? 2 * lower + 4 * upper
    : axis == 1              ? lower + 4 * upper
                             : lower + 2 * upper;
  return { from, from + (1 << axis) };
}

bool IsCrossed(unsigned cellCase, int edge)
{
  const auto [from, to] = VerticesOf(edge);
  return (cellCase >> from & 1) != (cellCase >> to & 1);
}

// The sides that belong to one triangle only.
std::set<Side> OutlineOf(const std::vector<Triangle>& triangles)
{
  std::set<Side> sides;
  for (const Triangle& triangle : triangles)
  {
    for (std::size_t n = 0; n < 3; ++n)
    {
      const Side side{ triangle[n], triangle[(n + 1) % 3] };
      if (sides.erase({ side.second, side.first }) == 0)
      {
        sides.insert(side);
      }
    }
  }
  return sides;
}

} // namespace

TEST(MarchingCubesCases, TrianglesUseExactlyTheCrossedEdges)
{
  for (unsigned cellCase = 0; cellCase < 256; ++cellCase)
  {
    std::set<int> used;
    for (const Triangle& triangle : TrianglesOf(cellCase))
    {
      used.insert(triangle.begin(), triangle.end());
    }
    for (int edge = 0; edge < 12; ++edge)
    {
      EXPECT_EQ(used.count(edge) == 1, IsCrossed(cellCase, edge)) << cellCase << " " << edge;
    }
  }
}

TEST(MarchingCubesCases, OutlinesLieOnFacesAndAgreeBetweenNeighbours)
{
  // The outline on a cell's high face must be the reverse of the next cell's on its low face.
  for (int axis = 0; axis < 3; ++axis)
  {
    std::map<unsigned, std::set<Side>> drawn[2]; // by side of the cell, then by the face's vertices
    for (unsigned cellCase = 0; cellCase < 256; ++cellCase)
    {
      const std::set<Side> outline = OutlineOf(TrianglesOf(cellCase));
      for (unsigned high = 0; high < 2; ++high)
      {
        unsigned faceCase = 0;
        std::set<Side> onFace;
        for (unsigned vertex = 0; vertex < 8; ++vertex)
        {
          if ((vertex >> axis & 1) == high)
          {
            faceCase |= (cellCase >> vertex & 1) << (vertex & ~(1u << axis));
          }
        }
        const auto isOnFace = [axis, high](int edge)
        {
          const auto [from, to] = VerticesOf(edge);
          return (static_cast<unsigned>(from) >> axis & 1) == high &&
            (static_cast<unsigned>(to) >> axis & 1) == high;
        };
        const auto nameOf = [axis](int edge)
        {
          const auto [from, to] = VerticesOf(edge);
          return 8 * (from & ~(1 << axis)) + (to & ~(1 << axis));
        };
        for (const Side& side : outline)
        {
          if (isOnFace(side.first) && isOnFace(side.second))
          {
            onFace.insert(high == 1 ? Side{ nameOf(side.first), nameOf(side.second) }
                                    : Side{ nameOf(side.second), nameOf(side.first) });
          }
        }
        const auto added = drawn[high].emplace(faceCase, onFace);
        EXPECT_EQ(added.first->second, onFace) << cellCase;
      }
    }
    EXPECT_EQ(drawn[0], drawn[1]);
  }
}

TEST(MarchingCubesCases, KnownCasesEqualThePublishedTable)
{
  EXPECT_TRUE(TrianglesOf(0).empty());
  EXPECT_TRUE(TrianglesOf(255).empty());
  EXPECT_EQ(TrianglesOf(1), (std::vector<Triangle>{ { 0, 4, 8 } }));
  EXPECT_EQ(TrianglesOf(3), (std::vector<Triangle>{ { 5, 4, 8 }, { 9, 5, 8 } }));
}

TEST(MarchingCubesCases, PolygonsHaveTheOutlineOfTheTriangles)
{
  for (unsigned cellCase = 0; cellCase < 256; ++cellCase)
  {
    const std::vector<Triangle> triangles = TrianglesOf(cellCase);
    const PolygonCase& polygons = GetCellCases(false).Polygons[cellCase];
    std::set<Side> sides;
    std::size_t corner = 0;
    for (std::size_t polygon = 0; polygon < polygons.NumberOfPolygons; ++polygon)
    {
      const std::size_t size = polygons.Sizes[polygon];
      EXPECT_GE(size, 3u);
      for (std::size_t n = 0; n < size; ++n)
      {
        sides.insert({ polygons.Corners[corner + n], polygons.Corners[corner + (n + 1) % size] });
      }
      corner += size;
    }
    EXPECT_EQ(corner, polygons.NumberOfCorners);
    EXPECT_EQ(sides, OutlineOf(triangles));
    EXPECT_EQ(polygons.NumberOfCorners, triangles.size() + 2u * polygons.NumberOfPolygons);
  }
}
