// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/PlaneLattice.h"
#include "Fixtures/VolumeOnDisk.h"

#include <algorithm>
#include <cmath>
#include <random>

using namespace isosurface;

namespace
{

VertexBox MakeImageBox(const PlaneLattice& lattice)
{
  return { { 0, 0, 0 }, lattice.GetImage().GetDimensions() };
}

/// All points of an image, by number.
std::vector<std::array<double, 3>> CollectPoints(const PlaneLattice& lattice, const VertexBox& part)
{
  std::vector<std::array<double, 3>> all(static_cast<std::size_t>(part.GetNumberOfVertices()));
  std::vector<SamplePoint> points;
  const PointPortions portions = lattice.MakePortions(part);
  std::size_t given = 0;
  for (std::size_t portion = 0; portion < portions.Count; ++portion)
  {
    portions.Give(portion, points);
    for (const SamplePoint& point : points)
    {
      all[static_cast<std::size_t>(point.Number)] = point.Vertex;
    }
    given += points.size();
  }
  EXPECT_EQ(given, all.size());
  return all;
}

/// A rotated grid with unlike spacings and an extent that does not begin at 0.
GridGeometry MakeRotatedGrid()
{
  GridGeometry grid = MakeGeometry({ 40, 100, 70 });
  grid.Direction = { 0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1 };
  return grid;
}

std::array<double, 3> FindMiddle(const GridGeometry& grid, const GridLines* lines = nullptr)
{
  const Index3 size = grid.GetDimensions();
  return VertexPlaces(grid, lines)
    .FindPoint({ static_cast<double>(size[0] / 2), static_cast<double>(size[1] / 2),
      static_cast<double>(size[2] / 2) });
}

} // namespace

TEST(PlaneLattice, APlaneAlongTwoAxesHasTheVerticesOfTheGrid)
{
  for (const GridGeometry& grid : { MakeGeometry({ 40, 100, 70 }), MakeRotatedGrid() })
  {
    const Index3 size = grid.GetDimensions();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      // The length of a normal, and on which side it is, do not matter.
      const double length = axis == 1 ? -20 : 0.01;
      const Plane plane{ FindMiddle(grid),
        { length * grid.Direction[axis], length * grid.Direction[3 + axis],
          length * grid.Direction[6 + axis] } };
      const auto lattice = PlaneLattice::Make(grid, nullptr, plane);
      ASSERT_TRUE(lattice);
      const VertexBox whole = MakeImageBox(*lattice);
      const std::size_t first = axis == 0 ? 1 : 0;
      const std::size_t second = axis == 2 ? 1 : 2;
      EXPECT_EQ(whole.High, (Index3{ size[first], size[second], 1 }));
      const auto points = CollectPoints(*lattice, whole);
      const VertexPlaces image(lattice->GetImage());
      const VertexPlaces places(grid);
      std::size_t wrong = 0;
      VisitVertices(whole,
        [&](const Index3& at)
        {
          std::array<double, 3> expected{};
          expected[axis] = static_cast<double>(size[axis] / 2);
          expected[first] = static_cast<double>(at[0]);
          expected[second] = static_cast<double>(at[1]);
          wrong += points[whole.FindIndex(at)] != expected;
          // The image is where the vertices are.
          const auto world = image.FindPoint({ expected[first], expected[second], 0 });
          const auto vertex = places.FindVertex(world);
          for (std::size_t along = 0; along < 3; ++along)
          {
            wrong += std::abs(vertex[along] - expected[along]) > 1e-9;
          }
        });
      EXPECT_EQ(wrong, 0u);
    }
  }
}

TEST(PlaneLattice, AnyPlaneIsCoveredWithinACell)
{
  std::mt19937 random(3);
  const auto choose = [&](double low, double high)
  { return std::uniform_real_distribution<double>(low, high)(random); };
  GridGeometry lined = MakeGeometry({ 5, 4, 6 });
  lined.Extent = { 0, 4, 0, 3, 0, 5 };
  const GridLines lines{ { { { 0, 1, 3, 4, 9 }, { -2, 0, 1, 7 }, { 1, 2, 3, 4, 5, 8 } } } };
  for (int repeat = 0; repeat < 60; ++repeat)
  {
    const bool isLined = repeat % 3 == 0;
    const GridGeometry grid = isLined ? lined : MakeRotatedGrid();
    const GridLines* gridLines = isLined ? &lines : nullptr;
    const VertexPlaces places(grid, gridLines);
    const Plane plane{ FindMiddle(grid, gridLines),
      { choose(-1, 1), choose(-1, 1), choose(-1, 1) } };
    const auto lattice = PlaneLattice::Make(grid, gridLines, plane);
    ASSERT_TRUE(lattice);
    const VertexPlaces image(lattice->GetImage());
    const VertexBox whole = MakeImageBox(*lattice);
    const auto points = CollectPoints(*lattice, whole);
    std::size_t wrong = 0;
    VisitVertices(whole,
      [&](const Index3& at)
      {
        const auto world =
          image.FindPoint({ static_cast<double>(at[0]), static_cast<double>(at[1]), 0 });
        double height = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          height += (world[axis] - plane.Origin[axis]) * plane.Normal[axis];
        }
        wrong += std::abs(height) > 1e-9 * (1 + std::abs(plane.Origin[2]));
        const auto vertex = places.FindVertex(world);
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          wrong += std::abs(vertex[axis] - points[whole.FindIndex(at)][axis]) > 1e-9;
        }
      });
    EXPECT_EQ(wrong, 0u);
    int tried = 0;
    // Points of the plane within the grid are no further from the image than a cell's edge.
    for (int trial = 0; trial < 200; ++trial)
    {
      const auto width = static_cast<double>(whole.High[0]);
      const auto height = static_cast<double>(whole.High[1]);
      const auto at =
        image.FindPoint({ choose(-width, 2 * width), choose(-height, 2 * height), 0 });
      const auto vertex = places.FindVertex(at);
      bool isWithin = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        isWithin &=
          vertex[axis] >= 0 && vertex[axis] <= static_cast<double>(grid.GetDimensions()[axis] - 1);
      }
      const auto place = image.FindVertex(at);
      tried += isWithin ? 1 : 0;
      for (std::size_t axis = 0; isWithin && axis < 2; ++axis)
      {
        EXPECT_GE(place[axis], -1e-6);
        EXPECT_LE(place[axis], static_cast<double>(whole.High[axis]));
      }
    }
    EXPECT_GT(tried, 0);
  }
}

TEST(PlaneLattice, AnObliquePlaneHasNoMorePointsThanItMay)
{
  GridGeometry grid = MakeGeometry({ 40, 100, 70 });
  grid.Spacing = { 1, 1, 1e-6 }; // the smallest spacing is that of the pixels
  for (const double maximum : { 4.0, 100.0, 12345.0, 1e6 })
  {
    const auto lattice =
      PlaneLattice::Make(grid, nullptr, { FindMiddle(grid), { 1, 0.3, 2e-5 } }, maximum);
    ASSERT_TRUE(lattice);
    const auto points = static_cast<double>(lattice->GetImage().GetNumberOfVertices());
    EXPECT_LE(points, maximum);
    EXPECT_GE(points, maximum / 4);
  }
}

TEST(PlaneLattice, ASliceHasNoMorePointsThanItMayInEachLayerOfVertices)
{
  const Index3 size{ 50, 37, 70 };
  MemoryDisk disk;
  const auto volume = WriteAndOpen(disk, MakeVolume<std::int16_t>(size), MakeSettings(16, 2));
  const GridGeometry& grid = volume->GetHeader().Grid;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::size_t first = axis == 0 ? 1 : 0;
    const std::size_t second = axis == 2 ? 1 : 2;
    std::array<double, 3> normal{};
    normal[axis] = 1;
    for (std::int64_t layer = 0; layer < size[axis]; ++layer)
    {
      std::array<double, 3> place{ 1, 1, 1 };
      place[axis] = static_cast<double>(layer);
      const Plane plane{ VertexPlaces(grid).FindPoint(place), normal };
      for (const std::int64_t maximum : { 4, 100, 300, 1000, 3000, 100000 })
      {
        int level = 0;
        const auto count = [&](std::size_t along, int of)
        { return (size[along] - 1) / (std::int64_t{ 1 } << of) + 1; };
        while (level < volume->GetNumberOfLevels() &&
          count(first, level) * count(second, level) > maximum)
        {
          ++level;
        }
        const bool isThere = level < volume->GetNumberOfLevels();
        const auto found = FindLatticeWithin(*volume, plane, static_cast<double>(maximum));
        ASSERT_TRUE(found);
        EXPECT_LE(found->Lattice.GetImage().GetNumberOfVertices(), maximum);
        EXPECT_EQ(found->Level, isThere ? level : level - 1);
        EXPECT_EQ(found->Lattice.IsAligned(), isThere);
        // In its place, or, beyond the level's last vertices, at these.
        const auto shown =
          static_cast<double>(std::min(layer, (count(axis, found->Level) - 1) << found->Level));
        const auto at = VertexPlaces(grid).FindVertex(found->Lattice.GetImage().Origin);
        EXPECT_NEAR(at[axis], shown, 1e-6) << "axis " << axis << ", layer " << layer;
      }
    }
  }
}

TEST(PlaneLattice, ATiltedSliceHasNoMorePointsThanItMayUpToTheLastCorner)
{
  const Index3 size{ 50, 37, 70 };
  MemoryDisk disk;
  const auto volume = WriteAndOpen(disk, MakeVolume<std::int16_t>(size), MakeSettings(16, 2));
  const VertexPlaces places(volume->GetHeader().Grid);
  for (const auto& normal : { std::array<double, 3>{ 0, 0.001, 1 }, { 1, 2, 3 }, { 1, -1e-6, 0 } })
  {
    for (int step = 0; step <= 200; ++step)
    {
      const double part = step / 200.0;
      const Plane plane{ places.FindPoint({ part * 49, part * 36, part * 69 }), normal };
      for (const double maximum : { 4.0, 100.0, 1000.0 })
      {
        for (const int firstLevel : { 0, 1 })
        {
          const auto found = FindLatticeWithin(*volume, plane, maximum, firstLevel);
          EXPECT_TRUE(found || firstLevel > 0);
          EXPECT_LE(found ? found->Lattice.CountPoints() : 0, maximum);
          EXPECT_GE(found ? found->Level : firstLevel, firstLevel);
        }
      }
    }
  }
}

TEST(PlaneLattice, PartsHaveThePointsOfTheWhole)
{
  const GridGeometry grid = MakeRotatedGrid();
  const auto lattice = PlaneLattice::Make(grid, nullptr, { FindMiddle(grid), { 1, 2, 3 } });
  ASSERT_TRUE(lattice);
  const VertexBox whole = MakeImageBox(*lattice);
  const auto points = CollectPoints(*lattice, whole);
  const VertexBox part{ { 3, 17, 0 }, { 75, whole.High[1], 1 } };
  const auto some = CollectPoints(*lattice, part);
  VisitVertices(part,
    [&](const Index3& at) { ASSERT_EQ(some[part.FindIndex(at)], points[whole.FindIndex(at)]); });
}

TEST(PlaneLattice, FacesAreCutAndAPlaneBesideTheGridIsNot)
{
  const GridGeometry grid = MakeGeometry({ 40, 100, 70 });
  const VertexPlaces places(grid);
  const auto cut = [&](double z) {
    return PlaneLattice::Make(grid, nullptr, { places.FindPoint({ 3, 3, z }), { 0, 0, 1 } });
  };
  EXPECT_TRUE(cut(0));
  EXPECT_TRUE(cut(69));
  EXPECT_FALSE(cut(-0.01));
  EXPECT_FALSE(cut(69.01));
  EXPECT_FALSE(PlaneLattice::Make(grid, nullptr, { places.FindPoint({ 3, 3, 3 }), { 0, 0, 0 } }));
  EXPECT_FALSE(PlaneLattice::Make(GridGeometry(), nullptr, {}));
  // A grid of one slice.
  EXPECT_TRUE(PlaneLattice::Make(MakeGeometry({ 4, 5, 1 }), nullptr,
    { VertexPlaces(MakeGeometry({ 4, 5, 1 })).FindPoint({ 0, 0, 0 }), { 0, 0, 1 } }));
}

TEST(PlaneLattice, AlignedSlicesAreThoseOfTheirPointsAndReadEachBlockOnce)
{
  const Index3 size{ 50, 37, 70 };
  const auto written = MakeVolume<std::int16_t>(size);
  MemoryDisk disk;
  const auto volume = WriteAndOpen(disk, written, MakeSettings(16, 2));
  for (int level = 0; level < 2; ++level)
  {
    const auto samples = Require(LevelSamples::Open(volume, 0, level));
    const GridGeometry grid = volume->GetHeader().Grid.Coarsen(level);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      // A vertex, between vertices, on a face of blocks and beside one, and the last vertex.
      const auto last = static_cast<double>(grid.GetDimensions()[axis] - 1);
      for (const double vertex : { 3.0, 3.25, 15.5, 16.0, 16.5, last - 0.5, last })
      {
        std::array<double, 3> place{ 1, 1, 1 };
        place[axis] = vertex;
        std::array<double, 3> normal{};
        normal[axis] = 1;
        const auto lattice =
          PlaneLattice::Make(grid, nullptr, { VertexPlaces(grid).FindPoint(place), normal });
        ASSERT_TRUE(lattice);
        VertexBox part = MakeImageBox(*lattice);
        part.Low = { 2, 5, 0 };
        const auto count = static_cast<std::size_t>(part.GetNumberOfVertices());
        for (const Interpolation interpolation : { Interpolation::Nearest, Interpolation::Linear })
        {
          std::vector<std::int16_t> expected(2 * count);
          std::vector<std::int16_t> found(2 * count);
          std::vector<std::uint8_t> isInside(count);
          QueryStatistics ofPoints;
          QueryStatistics ofSlice;
          ASSERT_TRUE(SamplePoints(*samples, 0, interpolation, lattice->MakePortions(part), 2,
            expected.data(), 2, isInside.data(), ofPoints)
                        .IsOk());
          ASSERT_TRUE(lattice
                        ->Sample(*samples, 0, interpolation, part, 2, found.data(), 2,
                          isInside.data(), ofSlice)
                        .IsOk());
          EXPECT_EQ(found, expected) << "axis " << axis << ", vertex " << vertex;
          EXPECT_EQ(
            std::count(isInside.begin(), isInside.end(), 1), static_cast<std::ptrdiff_t>(count));
          const BlockBox cover = samples->FindCover(samples->GetBox());
          const Index3 blocks = VertexBox{ cover.Low, cover.High }.GetSize();
          EXPECT_LE(ofSlice.BlocksRead + ofSlice.BlockCacheHits,
            static_cast<std::uint64_t>(blocks[0] * blocks[1] * blocks[2] / blocks[axis]));
        }
      }
    }
  }
}
