// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ProgressiveLevels.h"
#include "Fixtures/VolumeOnDisk.h"

using namespace isosurface;

namespace
{

/// Shells around a corner, far enough from each other for coarse levels to see them.
SampleVolume<std::uint8_t> MakeShells(const Index3& size)
{
  return SampleVolume<std::uint8_t>(size,
    [](auto i, auto j, auto k)
    { return static_cast<std::uint8_t>((i * i + j * j + k * k) / 160 % 200); });
}

SurfaceQuery MakeQuery(const std::vector<double>& isovalues)
{
  SurfaceQuery query;
  query.Isovalues = isovalues;
  return query;
}

int FindFirst(BlockedVolume& volume, const std::vector<double>& isovalues, int finest)
{
  return Require(FindFirstLevel(volume, MakeQuery(isovalues), finest));
}

} // namespace

TEST(ProgressiveLevels, BeginAtTheFinestOneWithATwentiethOfTheTriangles)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeShells({ 150, 140, 130 }), MakeSettings(16, 3));
  const auto count = [&](int level)
  {
    return *opened->EstimateTriangles(0, 0, 100, level) +
      *opened->EstimateTriangles(0, 0, 30, level);
  };
  for (int finest = 0; finest < 2; ++finest)
  {
    const int first = FindFirst(*opened, { 100, 30 }, finest);
    ASSERT_GT(first, finest + 1);
    ASSERT_LT(first, opened->GetNumberOfLevels() - 1);
    EXPECT_GT(count(first), 0);
    EXPECT_LE(20 * count(first), count(finest));
    EXPECT_GT(20 * count(first - 1), count(finest));
  }
}

TEST(ProgressiveLevels, NeverBeginWithAnEmptySurface)
{
  MemoryDisk disk;
  // A ball that the coarsest levels miss.
  WriteVolumeOk(disk,
    SampleVolume<std::uint8_t>({ 100, 100, 100 },
      [](auto i, auto j, auto k)
      {
        const auto square = (i - 50) * (i - 50) + (j - 51) * (j - 51) + (k - 53) * (k - 53);
        return static_cast<std::uint8_t>(square < 9 ? 100 : 0);
      }),
    MakeSettings(16, 3));
  const auto opened = OpenVolume(disk);
  const int coarsest = opened->GetNumberOfLevels() - 1;
  const int first = FindFirst(*opened, { 50 }, 0);
  EXPECT_GT(*opened->EstimateTriangles(0, 0, 50, first), 0);
  EXPECT_LT(first, coarsest);
  EXPECT_EQ(*opened->EstimateTriangles(0, 0, 50, first + 1), 0);

  EXPECT_EQ(FindFirst(*opened, { 0 }, 1), 1) << "a surface without triangles";
  EXPECT_EQ(FindFirst(*opened, {}, 0), 0) << "no isovalues";
  EXPECT_EQ(FindFirst(*opened, { 50 }, coarsest), coarsest) << "nothing is coarser";
}

TEST(ProgressiveLevels, EndWithTheFinestOneAndSkipThoseInItsBlocks)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeShells({ 150, 140, 130 }), MakeSettings(16, 3));
  for (int finest = 0; finest < opened->GetNumberOfLevels(); ++finest)
  {
    for (int level = opened->GetNumberOfLevels() - 1; level > finest;)
    {
      const int next = GetNextLevel(*opened, level, finest);
      ASSERT_LT(next, level);
      ASSERT_GE(next, finest);
      EXPECT_TRUE(next == finest || opened->FindLevel(next).Level == 0);
      if (level - next > 1)
      {
        EXPECT_EQ(opened->FindLevel(next).Part, opened->FindLevel(level - 1).Part);
      }
      level = next;
    }
  }
}

TEST(ProgressiveLevels, BetweenTheFirstAndTheLastAreForLargeSurfacesAlone)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeShells({ 150, 140, 130 }), MakeSettings(16, 3));
  EXPECT_TRUE(*IsDirectSurface(*opened, MakeQuery({ 100 }), 0));
  const double triangles = *opened->EstimateTriangles(0, 0, 100, 0);
  const auto many = static_cast<std::size_t>(DirectSurfaceTriangles / triangles) + 1;
  const SurfaceQuery query = MakeQuery(std::vector<double>(many, 100.0));
  EXPECT_FALSE(*IsDirectSurface(*opened, query, 0));
  EXPECT_TRUE(*IsDirectSurface(*opened, query, 3)) << "it is smaller at that level";
}
