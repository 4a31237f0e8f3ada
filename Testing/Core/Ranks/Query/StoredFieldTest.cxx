// SPDX-License-Identifier: BSD-3-Clause
// The levels of a volume's surface from coarse to final, and within a budget of time.
#include "Ranks/Query/StoredField.h"
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

/// Has a field asked for isovalues.
std::unique_ptr<StoredField> Ask(
  const std::shared_ptr<BlockedVolume>& volume, const std::vector<double>& isovalues)
{
  auto field = std::make_unique<StoredField>();
  ExtractionTask task;
  task.Volume = volume;
  task.Query.Isovalues = isovalues;
  field->Ask(task, {});
  return field;
}

Field::First FindFirst(
  const std::shared_ptr<BlockedVolume>& volume, const std::vector<double>& isovalues, int finest)
{
  SerialCommunicator alone;
  return Require(Ask(volume, isovalues)->FindFirst(alone, {}, finest));
}

/// A volume whose isosurface passes through one block alone.
SampleVolume<std::uint8_t> MakeDot(const Index3& size)
{
  return SampleVolume<std::uint8_t>(size,
    [](auto i, auto j, auto k)
    { return static_cast<std::uint8_t>(i == 5 && j == 5 && k == 5 ? 200 : 0); });
}

} // namespace

TEST(StoredField, BeginAtTheFinestOneWithATwentiethOfTheTriangles)
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
    const int first = FindFirst(opened, { 100, 30 }, finest).Level;
    ASSERT_GT(first, finest + 1);
    ASSERT_LT(first, opened->GetNumberOfLevels() - 1);
    EXPECT_GT(count(first), 0);
    EXPECT_LE(20 * count(first), count(finest));
    EXPECT_GT(20 * count(first - 1), count(finest));
  }
}

TEST(StoredField, NeverBeginWithAnEmptySurface)
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
  const int first = FindFirst(opened, { 50 }, 0).Level;
  EXPECT_GT(*opened->EstimateTriangles(0, 0, 50, first), 0);
  EXPECT_LT(first, coarsest);
  EXPECT_EQ(*opened->EstimateTriangles(0, 0, 50, first + 1), 0);

  EXPECT_EQ(FindFirst(opened, { 0 }, 1).Level, 1) << "a surface without triangles";
  EXPECT_EQ(FindFirst(opened, {}, 0).Level, 0) << "no isovalues";
  EXPECT_EQ(FindFirst(opened, { 50 }, coarsest).Level, coarsest) << "nothing is coarser";
}

TEST(StoredField, EndWithTheFinestOneAndSkipThoseInItsBlocks)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeShells({ 150, 140, 130 }), MakeSettings(16, 3));
  for (int finest = 0; finest < opened->GetNumberOfLevels(); ++finest)
  {
    for (int level = opened->GetNumberOfLevels() - 1; level > finest;)
    {
      const int next = Ask(opened, { 100 })->GetNextLevel(level, finest);
      ASSERT_LT(next, level);
      ASSERT_GE(next, finest);
      EXPECT_TRUE(next == finest || opened->FindLevel(next).Level == 0);
      if (level - next > 1)
      {
        EXPECT_EQ(opened->FindLevel(next).Overview, opened->FindLevel(level - 1).Overview);
      }
      level = next;
    }
  }
}

TEST(StoredField, BetweenTheFirstAndTheLastAreForLargeSurfacesAlone)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeShells({ 150, 140, 130 }), MakeSettings(16, 3));
  EXPECT_TRUE(FindFirst(opened, { 100 }, 0).IsDirect);
  const double triangles = *opened->EstimateTriangles(0, 0, 100, 0);
  const auto many = static_cast<std::size_t>(DirectSurfaceTriangles / triangles) + 1;
  const std::vector<double> isovalues(many, 100.0);
  EXPECT_FALSE(FindFirst(opened, isovalues, 0).IsDirect);
  EXPECT_TRUE(FindFirst(opened, isovalues, 3).IsDirect) << "it is smaller at that level";
}

// A rank without active blocks measures nothing: it would choose a level by a coarse extraction
// first, while the others go on to the next collective.
TEST(StoredField, RanksWithoutActiveBlocksGoTheWayOfTheOthers)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeDot({ 60, 50, 40 }), MakeSettings(16, 1), 1);
  constexpr int ranks = 3;
  std::vector<std::vector<std::uint64_t>> triangles(ranks);
  std::vector<std::vector<int>> levels(ranks);
  ThreadCommunicator::Run(ranks,
    [&](Communicator& communicator)
    {
      const auto rank = static_cast<std::size_t>(communicator.GetRank());
      const auto volume = OpenVolume(disk);
      SurfaceQuery query{ { 0, 0, { 100 } }, communicator.GetRank(), ranks };
      ContourRequest request;
      request.Isovalues = query.Isovalues;
      StoredField field;
      field.Ask({ volume, query, request, 1, {} }, { 1000, 0 });
      for (int time = 0; time < 4; ++time)
      {
        ExtractionOutcome outcome;
        const Status status = field.Extract(communicator, 0, outcome);
        EXPECT_TRUE(status.IsOk()) << status.GetMessage();
        triangles[rank].push_back(outcome.Extracted.NumberOfTriangles);
        levels[rank].push_back(outcome.Cost.Level);
      }
    });
  for (std::size_t time = 0; time < 4; ++time)
  {
    std::uint64_t sum = 0;
    for (std::size_t rank = 0; rank < ranks; ++rank)
    {
      sum += triangles[rank].at(time);
      EXPECT_EQ(levels[rank].at(time), 0);
    }
    EXPECT_EQ(sum, 8u) << "an octahedron around the one vertex that is inside";
  }
}
