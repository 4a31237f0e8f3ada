// SPDX-License-Identifier: BSD-3-Clause
// The connected parts of a surface, and which of them are kept. The oracle walks from triangle to
// triangle over the whole surface, and sums with long double.
#include "Ranks/Islands/IslandChoice.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/ThreadCommunicator.h"

#include <cmath>
#include <deque>
#include <set>

using namespace isosurface;

namespace
{

constexpr int BlockSize = 16;

/// An island as the oracle finds it.
struct PlainIsland
{
  std::uint64_t Triangles = 0;
  double Area = 0;
  double Volume = 0;
  std::int64_t FirstId = 0;
  PlainSurface Part;
};

std::array<long double, 3> PlaceOf(const PlainSurface& surface, std::int64_t id)
{
  std::array<long double, 3> place{};
  for (std::size_t n = 0; n < 3; ++n)
  {
    float value = 0;
    std::memcpy(&value, &surface.Points.at(id)[n], sizeof(value));
    place[n] = value;
  }
  return place;
}

void MeasureByForce(PlainIsland& island)
{
  long double area = 0;
  long double volume = 0;
  const auto origin = PlaceOf(island.Part, island.FirstId);
  for (const auto& triangle : island.Part.Triangles)
  {
    std::array<std::array<long double, 3>, 3> arms{};
    for (std::size_t n = 0; n < 3; ++n)
    {
      const auto place = PlaceOf(island.Part, triangle[n]);
      arms[n] = { place[0] - origin[0], place[1] - origin[1], place[2] - origin[2] };
    }
    const auto cross = [](const auto& a, const auto& b)
    {
      return std::array<long double, 3>{ a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0] };
    };
    const auto n = cross(arms[1], arms[2]);
    volume += (arms[0][0] * n[0] + arms[0][1] * n[1] + arms[0][2] * n[2]) / 6;
    const std::array<long double, 3> ab = { arms[1][0] - arms[0][0], arms[1][1] - arms[0][1],
      arms[1][2] - arms[0][2] };
    const std::array<long double, 3> ac = { arms[2][0] - arms[0][0], arms[2][1] - arms[0][1],
      arms[2][2] - arms[0][2] };
    const auto normal = cross(ab, ac);
    area += std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]) / 2;
  }
  island.Triangles = island.Part.Triangles.size();
  island.Area = static_cast<double>(area);
  island.Volume = static_cast<double>(std::abs(volume));
}

/// By a walk from point to point; the largest first.
std::vector<PlainIsland> FindByForce(
  const PlainSurface& surface, const std::function<double(const PlainIsland&)>& size)
{
  std::map<std::int64_t, std::vector<std::size_t>> trianglesAt;
  for (std::size_t n = 0; n < surface.Triangles.size(); ++n)
  {
    for (const std::int64_t id : surface.Triangles[n])
    {
      trianglesAt[id].push_back(n);
    }
  }
  std::vector<PlainIsland> islands;
  std::set<std::int64_t> seen;
  for (const auto& [first, triangles] : trianglesAt)
  {
    if (!seen.insert(first).second)
    {
      continue;
    }
    PlainIsland island;
    island.FirstId = first;
    std::set<std::size_t> own;
    std::deque<std::int64_t> ahead = { first };
    for (; !ahead.empty(); ahead.pop_front())
    {
      island.Part.Points[ahead.front()] = surface.Points.at(ahead.front());
      for (const std::size_t triangle : trianglesAt[ahead.front()])
      {
        own.insert(triangle);
        for (const std::int64_t id : surface.Triangles[triangle])
        {
          if (seen.insert(id).second)
          {
            ahead.push_back(id);
          }
        }
      }
    }
    for (const std::size_t triangle : own)
    {
      island.Part.Triangles.push_back(surface.Triangles[triangle]);
    }
    MeasureByForce(island);
    islands.push_back(std::move(island));
  }
  std::stable_sort(islands.begin(), islands.end(),
    [&](const PlainIsland& a, const PlainIsland& b) { return size(a) > size(b); });
  return islands;
}

double CountTriangles(const PlainIsland& island)
{
  return static_cast<double>(island.Triangles);
}

PlainSurface Unite(const std::vector<PlainIsland>& islands, std::size_t count)
{
  PlainSurface surface;
  for (std::size_t n = 0; n < std::min(count, islands.size()); ++n)
  {
    surface.Points.insert(islands[n].Part.Points.begin(), islands[n].Part.Points.end());
    surface.Triangles.insert(
      surface.Triangles.end(), islands[n].Part.Triangles.begin(), islands[n].Part.Triangles.end());
  }
  std::sort(surface.Triangles.begin(), surface.Triangles.end());
  return surface;
}

/// Some large bodies that pass through many blocks, in a dust of single vertices. Nothing at the
/// border, so that all islands are closed.
SampleVolume<float> MakeDust()
{
  std::mt19937 random(5);
  const Index3 size = { 50, 45, 40 };
  SampleVolume<float> volume(size,
    [&](auto i, auto j, auto k)
    {
      const auto x = static_cast<double>(i);
      const auto y = static_cast<double>(j);
      const auto z = static_cast<double>(k);
      const bool isBorder =
        i == 0 || j == 0 || k == 0 || i + 1 == size[0] || j + 1 == size[1] || k + 1 == size[2];
      const double ball = 10 - std::hypot(x - 17, y - 16, z - 16);
      const double ring = 4 - std::hypot(std::hypot(x - 30, y - 28) - 13, z - 30);
      const bool isDust = random() % 60 == 0;
      const double noise = static_cast<double>(random() % 1000) / 1000;
      return isBorder ? -9 : std::max({ ball, ring, isDust ? noise : -1 - noise });
    });
  volume.Geometry.Spacing = { 0.5, 0.25, 2 };
  volume.Geometry.Origin = { 100, -30, 7 };
  return volume;
}

struct Outcome
{
  PlainSurface Kept;
  ChosenIslands Chosen;
};

/// What ranks have kept, to which blocks were dealt at random.
template <typename T>
Outcome Choose(const SampleVolume<T>& volume, const ContourRequest& contour,
  const IslandRequest& request, int ranks, int threads, unsigned int seed = 1)
{
  std::vector<Outcome> outcomes(static_cast<std::size_t>(ranks));
  ThreadCommunicator::Run(ranks,
    [&](Communicator& communicator)
    {
      TestBlockSource<T> source(volume, BlockSize);
      std::mt19937 random(seed);
      const auto blocks = std::exchange(source.Blocks, {});
      for (const std::int64_t block : blocks)
      {
        if (static_cast<int>(random() % static_cast<unsigned int>(ranks)) == communicator.GetRank())
        {
          source.Blocks.push_back(block);
        }
      }
      Surface surface = Require(ExtractSurface(volume.Geometry, source, contour, threads));
      IslandGrids grids;
      grids.Bounds = TriangleBounds::Of(volume.Geometry, contour.Lines);
      grids.Shared.emplace_back(volume.Geometry, contour);
      grids.Shared.back().AddFacesOfBlocks(BlockSize);
      Outcome& mine = outcomes[static_cast<std::size_t>(communicator.GetRank())];
      const Status status =
        ChooseIslands(communicator, request, grids, threads, surface, mine.Chosen);
      EXPECT_TRUE(status.IsOk()) << status.GetMessage();
      ExpectWholeParts(surface);
      mine.Kept = MakePlain(surface);
    });
  std::vector<PlainSurface> surfaces;
  for (Outcome& outcome : outcomes)
  {
    surfaces.push_back(std::move(outcome.Kept));
    EXPECT_EQ(outcome.Chosen.KeptTriangles, outcomes.front().Chosen.KeptTriangles);
  }
  Outcome united = std::move(outcomes.front());
  united.Kept = UniteRanks(surfaces);
  return united;
}

} // namespace

class IslandsOnRanks : public testing::TestWithParam<int>
{
};

TEST_P(IslandsOnRanks, AreThoseOfAWalkOverAllTriangles)
{
  const auto volume = MakeDust();
  for (const bool isClosed : { false, true })
  {
    ContourRequest contour = MakePlainRequest({ 0.25, 5 });
    contour.ClosedSides = isClosed ? GridSides::All() : GridSides();
    contour.DropDegenerateTriangles = isClosed;
    const PlainSurface whole = MakePlain(ExtractBlocks(volume, BlockSize, contour));
    const auto expected = FindByForce(whole, CountTriangles);
    ASSERT_GT(expected.size(), 300u) << "dust";

    const Outcome all = Choose(volume, contour, {}, GetParam(), 2);
    EXPECT_TRUE(all.Kept == whole) << "without a limit, all is kept";
    EXPECT_EQ(all.Chosen.Islands, expected.size());
    EXPECT_EQ(all.Chosen.KeptIslands, expected.size());
    EXPECT_EQ(all.Chosen.Triangles, whole.Triangles.size());
    ASSERT_EQ(all.Chosen.Largest.size(), std::min(expected.size(), MaximumListedIslands));
    for (std::size_t n = 0; n < all.Chosen.Largest.size(); ++n)
    {
      const ListedIsland& listed = all.Chosen.Largest[n];
      EXPECT_EQ(listed.Triangles, expected[n].Triangles) << n;
      EXPECT_NEAR(listed.Area, expected[n].Area, 1e-9 * expected[n].Area + 1e-12) << n;
      EXPECT_NEAR(listed.Volume, expected[n].Volume, 1e-6 * expected[n].Volume + 1e-9) << n;
    }
    std::uint64_t triangles = 0;
    for (const IslandBin& bin : all.Chosen.Bins)
    {
      const auto isIn = [&bin](const PlainIsland& island)
      { return CountTriangles(island) >= bin.Size && CountTriangles(island) < 2 * bin.Size; };
      EXPECT_EQ(bin.Islands,
        static_cast<std::uint64_t>(std::count_if(expected.begin(), expected.end(), isIn)));
      triangles += bin.Triangles;
    }
    EXPECT_EQ(triangles, whole.Triangles.size());
  }
}

TEST_P(IslandsOnRanks, AreKeptBySizeAndNumber)
{
  const auto volume = MakeDust();
  const ContourRequest contour = MakePlainRequest({ 0.25 });
  const PlainSurface whole = MakePlain(ExtractBlocks(volume, BlockSize, contour));
  const std::pair<IslandSize, std::function<double(const PlainIsland&)>> sizes[] = {
    { IslandSize::Triangles, CountTriangles },
    { IslandSize::Area, [](const PlainIsland& island) { return island.Area; } },
    { IslandSize::Volume, [](const PlainIsland& island) { return island.Volume; } }
  };
  for (const auto& [kind, size] : sizes)
  {
    const auto expected = FindByForce(whole, size);
    IslandRequest request;
    request.Size = kind;
    for (const std::size_t count : { 1, 3, 4, 60, 100000 })
    {
      // Half of the islands are equal octahedra by triangles: those with lower ids come first.
      request.MaximumIslands = count;
      const Outcome most = Choose(volume, contour, request, GetParam(), 1);
      const std::size_t left = std::min(count, expected.size());
      EXPECT_EQ(most.Chosen.KeptIslands, left);
      if (kind == IslandSize::Triangles || count < 10)
      {
        EXPECT_TRUE(most.Kept == Unite(expected, count)) << count << " islands";
      }
    }
    request.MaximumIslands = 0;
    std::size_t kept = 4;
    while (size(expected[kept]) > 0.999 * size(expected[kept - 1]))
    {
      ++kept;
    }
    request.MinimumSize = (size(expected[kept - 1]) + size(expected[kept])) / 2;
    const Outcome large = Choose(volume, contour, request, GetParam(), 1);
    EXPECT_EQ(large.Chosen.KeptIslands, kept);
    EXPECT_EQ(large.Chosen.Islands, expected.size()) << "what was dropped is counted";
    EXPECT_TRUE(large.Kept == Unite(expected, kept));
  }
}

TEST_P(IslandsOnRanks, AreKeptAndCountedOfEachIsovalueByItself)
{
  const auto volume = MakeDust();
  IslandRequest request;
  for (const std::size_t count : { 1, 3, 60 })
  {
    request.MaximumIslands = count;
    const Outcome both = Choose(volume, MakePlainRequest({ 0.25, 5 }), request, GetParam(), 1);
    ASSERT_EQ(both.Chosen.OfIsovalues.size(), 2u);
    std::size_t triangles = 0;
    for (const std::size_t n : { 0, 1 })
    {
      const Outcome one =
        Choose(volume, MakePlainRequest({ n == 0 ? 0.25 : 5.0 }), request, GetParam(), 1);
      const IsovalueIslands& islands = both.Chosen.OfIsovalues[n];
      EXPECT_EQ(islands.Islands, one.Chosen.Islands);
      EXPECT_EQ(islands.KeptIslands, one.Chosen.KeptIslands);
      EXPECT_EQ(islands.KeptIslands, std::min<std::uint64_t>(count, one.Chosen.Islands));
      EXPECT_EQ(islands.KeptTriangles, one.Chosen.KeptTriangles);
      triangles += one.Kept.Triangles.size();
    }
    EXPECT_EQ(both.Kept.Triangles.size(), triangles);
  }
}

TEST_P(IslandsOnRanks, AtAPlaceIsTheNearestOne)
{
  const auto volume = MakeDust();
  const ContourRequest contour = MakePlainRequest({ 0.25 });
  const PlainSurface whole = MakePlain(ExtractBlocks(volume, BlockSize, contour));
  const auto expected = FindByForce(whole, CountTriangles);
  for (const std::size_t wanted : { 0, 1, 7, 200 })
  {
    // Within a triangle of the island.
    const PlainSurface& part = expected.at(wanted).Part;
    std::array<double, 3> place{};
    for (const std::int64_t id : part.Triangles[part.Triangles.size() / 2])
    {
      for (std::size_t n = 0; n < 3; ++n)
      {
        place[n] += static_cast<double>(PlaceOf(part, id)[n]) / 3;
      }
    }
    IslandRequest request;
    request.Place = place;
    const Outcome kept = Choose(volume, contour, request, GetParam(), 2);
    EXPECT_EQ(kept.Chosen.KeptIslands, 1u);
    EXPECT_TRUE(kept.Kept == part) << wanted;
    // Of those that are large enough, it is another one if this one is not.
    request.MinimumSize = CountTriangles(expected[0]);
    EXPECT_TRUE(Choose(volume, contour, request, GetParam(), 2).Kept == expected.front().Part);
  }
}

TEST_P(IslandsOnRanks, HaveTheSameMeasuresHoweverBlocksAreDealt)
{
  const auto volume = MakeDust();
  const ContourRequest contour = MakePlainRequest({ 0.25 });
  IslandRequest request;
  request.Size = IslandSize::Volume;
  request.MaximumIslands = 40;
  const Outcome one = Choose(volume, contour, request, 1, 1);
  for (const unsigned int seed : { 3u, 4u, 5u })
  {
    const Outcome other = Choose(volume, contour, request, GetParam(), 3, seed);
    EXPECT_TRUE(other.Kept == one.Kept);
    ASSERT_EQ(other.Chosen.Largest.size(), one.Chosen.Largest.size());
    for (std::size_t n = 0; n < one.Chosen.Largest.size(); ++n)
    {
      EXPECT_EQ(other.Chosen.Largest[n].Area, one.Chosen.Largest[n].Area) << "bit for bit";
      EXPECT_EQ(other.Chosen.Largest[n].Volume, one.Chosen.Largest[n].Volume) << "bit for bit";
    }
  }
}

TEST_P(IslandsOnRanks, OfNothingAreNone)
{
  const auto volume = MakeDust();
  IslandRequest request;
  request.MaximumIslands = 5;
  request.Ids = true;
  request.Place = { 1, 2, 3 };
  const Outcome none = Choose(volume, MakePlainRequest({ 1000 }), request, GetParam(), 2);
  EXPECT_EQ(none.Chosen.Islands, 0u);
  EXPECT_TRUE(none.Chosen.Largest.empty());
  EXPECT_TRUE(none.Kept.Triangles.empty());
}

INSTANTIATE_TEST_SUITE_P(Ranks, IslandsOnRanks, testing::ValuesIn(GetNumbersOfRanks()));

TEST(Islands, HaveIdsByTheirPlacesAmongAll)
{
  const auto volume = MakeDust();
  const ContourRequest contour = MakePlainRequest({ 0.25 });
  Surface surface = ExtractBlocks(volume, BlockSize, contour);
  const auto expected = FindByForce(MakePlain(surface), CountTriangles);
  IslandGrids grids;
  grids.Bounds = TriangleBounds::Of(volume.Geometry, nullptr);
  IslandRequest request;
  request.Ids = true;
  request.MinimumSize = CountTriangles(expected[20]);
  SerialCommunicator ranks;
  ChosenIslands chosen;
  ASSERT_TRUE(ChooseIslands(ranks, request, grids, 2, surface, chosen).IsOk());
  ASSERT_EQ(chosen.Ids.GetSize(), surface.NumberOfCells);
  for (std::size_t cell = 0; cell < surface.NumberOfCells; ++cell)
  {
    const auto corner = static_cast<std::size_t>(surface.Connectivity[3 * cell]);
    const auto& part = expected[static_cast<std::size_t>(chosen.Ids[cell])].Part;
    ASSERT_EQ(part.Points.count(surface.GlobalIds[corner]), 1u) << cell;
  }
}

TEST(Islands, OfPolygonsAreThoseOfTheirTriangles)
{
  const auto volume = MakeDust();
  ContourRequest contour = MakePlainRequest({ 0.25 });
  contour.Attributes = {};
  IslandGrids grids;
  grids.Bounds = TriangleBounds::Of(volume.Geometry, nullptr);
  IslandRequest request;
  request.MaximumIslands = 30;
  SerialCommunicator ranks;
  Surface triangles = ExtractBlocks(volume, BlockSize, contour);
  contour.Polygons = true;
  Surface polygons = ExtractBlocks(volume, BlockSize, contour);
  ChosenIslands ofTriangles;
  ChosenIslands ofPolygons;
  ASSERT_TRUE(ChooseIslands(ranks, request, grids, 2, triangles, ofTriangles).IsOk());
  ASSERT_TRUE(ChooseIslands(ranks, request, grids, 2, polygons, ofPolygons).IsOk());
  EXPECT_EQ(ofPolygons.Islands, ofTriangles.Islands);
  EXPECT_EQ(ofPolygons.KeptTriangles, ofTriangles.KeptTriangles);
  EXPECT_EQ(polygons.NumberOfTriangles, triangles.NumberOfTriangles);
  EXPECT_EQ(polygons.NumberOfPoints, triangles.NumberOfPoints);
  EXPECT_EQ(static_cast<std::size_t>(polygons.Offsets[polygons.NumberOfCells]),
    polygons.Connectivity.GetSize());
}

TEST(Islands, WithIndicesOf64BitsAreTheSame)
{
  const auto volume = MakeDust();
  ContourRequest contour = MakePlainRequest({ 0.25 });
  contour.WideIndices = true;
  contour.Offsets = true;
  IslandRequest request;
  request.MaximumIslands = 30;
  const Outcome wide = Choose(volume, contour, request, 3, 2);
  const Outcome plain = Choose(volume, MakePlainRequest({ 0.25 }), request, 3, 2);
  EXPECT_TRUE(wide.Kept == plain.Kept);
}

// A coarse level has a quarter of the triangles: a limit means those at full resolution.
TEST(Islands, CountTrianglesAsAtFullResolution)
{
  const auto volume = MakeDust();
  const ContourRequest contour = MakePlainRequest({ 0.25 });
  IslandRequest request;
  request.MinimumSize = 100;
  const Outcome exact = Choose(volume, contour, request, 1, 1);
  request.Level = 2;
  request.MinimumSize = 1600;
  const Outcome coarse = Choose(volume, contour, request, 1, 1);
  EXPECT_TRUE(exact.Kept == coarse.Kept);
  EXPECT_EQ(exact.Chosen.KeptTriangles, coarse.Chosen.KeptTriangles);
}

// Walls of NaN have points that are NaN.
TEST(Islands, WithoutPlacesHaveNoArea)
{
  SampleVolume<float> volume({ 9, 9, 9 });
  volume.At(4, 4, 4) = 1;
  volume.At(5, 4, 4) = std::numeric_limits<float>::quiet_NaN();
  const Outcome kept = Choose(volume, MakePlainRequest({ 0.5 }), {}, 1, 1);
  ASSERT_EQ(kept.Chosen.Largest.size(), 1u);
  EXPECT_GT(kept.Chosen.Largest[0].Area, 0);
  EXPECT_LT(kept.Chosen.Largest[0].Area, 10);
}
