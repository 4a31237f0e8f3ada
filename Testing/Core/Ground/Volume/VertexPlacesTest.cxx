// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/VertexPlaces.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

struct PlacedGrid
{
  GridGeometry Grid;
  std::vector<GridLines> Lines; ///< one of a rectilinear grid, else none
  bool IsAligned = true;        ///< whether its axes are the world's

  VertexPlaces GetPlaces() const
  {
    return VertexPlaces(this->Grid, this->Lines.empty() ? nullptr : this->Lines.data());
  }
};

std::vector<PlacedGrid> MakePlacedGrids()
{
  PlacedGrid regular;
  regular.Grid.Extent = { -3, 8, 0, 6, 10, 14 };
  regular.Grid.Origin = { 5, -1, 0.25 };
  regular.Grid.Spacing = { 0.5, 1.25, 2 };
  PlacedGrid turned = regular;
  turned.IsAligned = false;
  turned.Grid.Direction = { 0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, -1 };
  PlacedGrid lined = regular;
  lined.Lines.push_back({ { { { 0, 1, 3, 4, 9, 10, 11, 15, 16, 17, 19, 22 },
    { -2, 0, 1, 7, 8, 10, 11 }, { 1, 2, 3, 4.5, 5 } } } });
  PlacedGrid flat = regular;
  flat.Grid.Extent[5] = flat.Grid.Extent[4];
  return { regular, turned, lined, flat };
}

std::array<double, 3> ToVertex(const Index3& vertex)
{
  return { static_cast<double>(vertex[0]), static_cast<double>(vertex[1]),
    static_cast<double>(vertex[2]) };
}

} // namespace

TEST(VertexPlaces, APointOfAVertexIsFoundThere)
{
  for (const PlacedGrid& grid : MakePlacedGrids())
  {
    const VertexPlaces places = grid.GetPlaces();
    VisitVertices({ { 0, 0, 0 }, grid.Grid.GetDimensions() },
      [&](const Index3& vertex)
      {
        const auto found = places.FindVertex(places.FindPoint(ToVertex(vertex)));
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          EXPECT_NEAR(found[axis], static_cast<double>(vertex[axis]), 1e-12);
        }
      });
  }
}

TEST(VertexPlaces, VerticesAroundABoxAreThoseInItAndTheNextOnes)
{
  std::mt19937 random(4);
  const auto choose = [&](double low, double high)
  { return std::uniform_real_distribution<double>(low, high)(random); };
  int found = 0;
  for (const PlacedGrid& grid : MakePlacedGrids())
  {
    const VertexPlaces places = grid.GetPlaces();
    const VertexBox all{ { 0, 0, 0 }, grid.Grid.GetDimensions() };
    const auto middle = places.FindPoint({ 5, 3, all.High[2] > 1 ? 2.0 : 0.0 });
    for (int repeat = 0; repeat < 200; ++repeat)
    {
      std::array<double, 3> low{};
      std::array<double, 3> high{};
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        low[axis] = middle[axis] + choose(-8, 3);
        high[axis] = low[axis] + choose(0, 8);
      }
      const VertexBox box = places.FindVerticesAround(low, high);
      EXPECT_EQ(places.FindVerticesAround(high, low), box) << "corners in another order";
      found += box.IsEmpty() ? 0 : 1;
      // Vertices strictly in the box, and on each axis how far the vertices of the result reach.
      VisitVertices(all,
        [&](const Index3& vertex)
        {
          const auto point = places.FindPoint(ToVertex(vertex));
          bool isIn = true;
          for (std::size_t axis = 0; axis < 3; ++axis)
          {
            isIn &= point[axis] > low[axis] && point[axis] < high[axis];
          }
          EXPECT_TRUE(
            !isIn || box.Contains({ vertex, { vertex[0] + 1, vertex[1] + 1, vertex[2] + 1 } }));
        });
      for (std::size_t axis = 0; axis < 3 && grid.IsAligned && !box.IsEmpty(); ++axis)
      {
        const auto getPlace = [&](std::int64_t vertex)
        {
          std::array<double, 3> at{};
          at[axis] = static_cast<double>(vertex);
          return places.FindPoint(at)[axis];
        };
        // Without its first or last layer it would not reach around the box.
        EXPECT_TRUE(box.High[axis] - box.Low[axis] == 1 || getPlace(box.Low[axis] + 1) > low[axis]);
        EXPECT_TRUE(
          box.High[axis] - box.Low[axis] == 1 || getPlace(box.High[axis] - 2) < high[axis]);
      }
    }
  }
  EXPECT_GT(found, 300);
}

TEST(VertexPlaces, NoVerticesAreAroundABoxBesideTheGridOrNowhere)
{
  for (const PlacedGrid& grid : MakePlacedGrids())
  {
    const VertexPlaces places = grid.GetPlaces();
    EXPECT_TRUE(places.FindVerticesAround({ 1e6, 0, 0 }, { 2e6, 1, 1 }).IsEmpty());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(places.FindVerticesAround({ nan, 0, 0 }, { nan, 1, 1 }).IsEmpty());
    // A box as small as a vertex.
    const auto point = places.FindPoint({ 2, 3, 0 });
    const VertexBox one = places.FindVerticesAround(point, point);
    EXPECT_EQ(one.Low, (Index3{ 2, 3, 0 }));
    EXPECT_EQ(one.GetNumberOfVertices(), 1);
  }
}
