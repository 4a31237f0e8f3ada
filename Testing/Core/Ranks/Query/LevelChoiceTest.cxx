// SPDX-License-Identifier: BSD-3-Clause
// The level that a budget allows, against a test of all levels; and the rates that predict time.
#include "Ranks/Query/LevelChoice.h"
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/VolumeOnDisk.h"

using namespace isosurface;

namespace
{

constexpr double ChosenIsovalue = 50;

class LevelChoiceTest : public testing::Test
{
protected:
  void SetUp() override
  {
    WriteVolumeOk(this->Disk, MakeVolume<std::uint8_t>({ 200, 150, 130 }), MakeSettings(16, 3), 1);
    this->Opened = OpenVolume(this->Disk);
    this->Query.Isovalues = { ChosenIsovalue };
  }

  LevelChoice Choose(int finest, const ExtractionBudget& budget, const ExtractionRate& rate = {})
  {
    SerialCommunicator alone;
    QueryStatistics statistics;
    return Require(
      ChooseLevel(*this->Opened, this->Query, finest, budget, rate, alone, statistics));
  }
  std::uint64_t CountTriangles(int level)
  {
    double triangles = 0;
    for (const double isovalue : this->Query.Isovalues)
    {
      triangles += Require(this->Opened->EstimateTriangles(0, 0, isovalue, level));
    }
    return static_cast<std::uint64_t>(std::llround(triangles));
  }

  MemoryDisk Disk;
  std::shared_ptr<BlockedVolume> Opened;
  SurfaceQuery Query;
};

/// A rate that predicts so many seconds for each active block, and hardly any besides.
ExtractionRate LearnSecondsPerBlock(double seconds)
{
  ExtractionRate rate;
  for (int time = 0; time < 5; ++time)
  {
    rate.Observe({ 0, 1e9, 1e5, 1e9, 1e8 }, 0);
    for (const double blocks : { 1e3, 1e4 })
    {
      rate.Observe({ blocks, 0, 0, 0, 0 }, blocks * seconds);
    }
  }
  return rate;
}

} // namespace

TEST_F(LevelChoiceTest, IsTheFinestWhoseTrianglesFit)
{
  const int levels = this->Opened->GetNumberOfLevels();
  ASSERT_GT(levels, 4);
  for (const std::vector<double>& isovalues : { std::vector<double>{ 50.0 }, { 20.0, 90.0 } })
  {
    this->Query.Isovalues = isovalues;
    for (const int finest : { 0, 2 })
    {
      for (int level = 0; level < levels; ++level)
      {
        for (const std::uint64_t triangles :
          { this->CountTriangles(level), this->CountTriangles(level) - 1 })
        {
          int expected = finest;
          while (expected + 1 < levels && this->CountTriangles(expected) > triangles)
          {
            ++expected;
          }
          if (triangles == 0 || triangles > this->CountTriangles(0))
          {
            continue;
          }
          const LevelChoice choice = this->Choose(finest, { 0, triangles });
          EXPECT_EQ(choice.Level, expected) << triangles << " triangles";
          EXPECT_EQ(choice.Limit,
            expected == finest && this->CountTriangles(expected) <= triangles
              ? LevelLimit::None
              : LevelLimit::Triangles);
        }
      }
    }
  }
}

TEST_F(LevelChoiceTest, IsTheFinestWhoseBlocksAreDoneInTime)
{
  const ExtractionRate rate = LearnSecondsPerBlock(1e-4);
  std::vector<double> seconds;
  for (int level = 0; level < this->Opened->GetNumberOfLevels(); ++level)
  {
    QueryStatistics statistics;
    const auto active = Require(
      FindActiveBlocks(*this->Opened, { { 0, 0, this->Query.Isovalues } }, statistics, level));
    seconds.push_back(1e-4 * static_cast<double>(active.size()));
  }
  for (const double budget : { 0.004, 0.02, 0.08, 0.2 })
  {
    int expected = 0;
    while (expected + 1 < static_cast<int>(seconds.size()) &&
      seconds[static_cast<std::size_t>(expected)] > budget)
    {
      ++expected;
    }
    const LevelChoice choice = this->Choose(0, { budget, 0 }, rate);
    EXPECT_EQ(choice.Level, expected) << budget << " seconds";
    EXPECT_NEAR(
      choice.Seconds, seconds[static_cast<std::size_t>(choice.Level)], 0.1 * choice.Seconds + 1e-3);
    EXPECT_EQ(choice.Limit, budget > seconds[0] ? LevelLimit::None : LevelLimit::Seconds);
  }
}

TEST_F(LevelChoiceTest, IsThatOfTheSlowestRankOnAllRanks)
{
  const int alone = this->Choose(0, { 0.02, 0 }, LearnSecondsPerBlock(1e-4)).Level;
  EXPECT_GT(alone, 0);
  const std::vector<int> chosen = ThreadCommunicator::Collect(3,
    [&](Communicator& ranks)
    {
      SurfaceQuery query = this->Query;
      query.Rank = ranks.GetRank();
      query.Ranks = ranks.GetSize();
      QueryStatistics statistics;
      const auto choice = ChooseLevel(*this->Opened, query, 0, { 0.02, 0 },
        LearnSecondsPerBlock(ranks.GetRank() == 1 ? 1e-4 : 1e-6), ranks, statistics);
      return choice.IsOk() ? choice->Level : -1;
    });
  EXPECT_GT(chosen[0], 0);
  EXPECT_LE(chosen[0], alone) << "a rank has but a share of the blocks";
  EXPECT_EQ(chosen, std::vector<int>(3, chosen[0]));
}

TEST_F(LevelChoiceTest, OfARegionCountsItsShareOfTheTriangles)
{
  const std::uint64_t all = this->CountTriangles(0);
  EXPECT_GT(this->Choose(0, { 0, all / 2 }).Level, 0);
  std::array<double, 6> bounds = { -1e9, 1e9, -1e9, 1e9, -1e9, 0 };
  const GridGeometry grid = this->Opened->GetHeader().Grid;
  bounds[5] = grid.Origin[2] + grid.Spacing[2] * static_cast<double>(grid.Extent[4] + 20);
  this->Query.Selection.Region = Region::FromBounds(bounds);
  EXPECT_EQ(this->Choose(0, { 0, all / 2 }).Level, 0);
}

TEST_F(LevelChoiceTest, ErrorsOfOneRankReachAll)
{
  for (const auto& file : this->Disk.Copy())
  {
    if (file.first.find("store-00001/") != std::string::npos &&
      file.first.find(".tree") != std::string::npos)
    {
      this->Disk.GetFile(file.first).resize(100);
    }
  }
  for (const std::string& message : ThreadCommunicator::Collect(3,
         [&](Communicator& ranks)
         {
           SurfaceQuery query = this->Query;
           query.Rank = ranks.GetRank();
           query.Ranks = ranks.GetSize();
           QueryStatistics statistics;
           const auto choice =
             ChooseLevel(*this->Opened, query, 0, { 1, 0 }, ExtractionRate(), ranks, statistics);
           return choice.GetStatus().GetMessage();
         }))
  {
    EXPECT_NE(message.find("store-00001"), std::string::npos) << message;
  }
}

TEST(ExtractionRate, LearnsTheCostsOfWork)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(0, 1);
  const auto makeWork = [&]
  {
    ExtractionWork work;
    work.Blocks = std::pow(10, 5 * exponent(random));
    work.SampleBytes = work.Blocks * std::pow(10, 3 + 2 * exponent(random));
    work.ReadBytes = exponent(random) < 0.5 ? 0 : work.SampleBytes * exponent(random);
    work.BlocksRead = work.ReadBytes > 0 ? work.Blocks * exponent(random) : 0;
    work.Triangles = work.Blocks * std::pow(10, 1 + 3 * exponent(random));
    return work;
  };
  const auto measure = [](const ExtractionWork& work)
  {
    return 5e-4 + 1e-5 * work.Blocks + 4e-10 * work.SampleBytes + 1e-4 * work.BlocksRead +
      2e-8 * work.ReadBytes + 5e-9 * work.Triangles;
  };
  ExtractionRate rate;
  EXPECT_FALSE(rate.IsKnown());
  for (int time = 0; time < 2000; ++time)
  {
    const ExtractionWork work = makeWork();
    rate.Observe(work, measure(work));
  }
  EXPECT_TRUE(rate.IsKnown());
  for (int time = 0; time < 100; ++time)
  {
    const ExtractionWork work = makeWork();
    EXPECT_NEAR(rate.Predict(work) / measure(work), 1, 0.3);
  }
}

TEST(ExtractionRate, OutlierHardlyChangesIt)
{
  ExtractionWork work;
  work.Blocks = 1000;
  for (const double outlier : { 1e9, 0.0 })
  {
    ExtractionRate rate;
    for (int time = 0; time < 15; ++time)
    {
      rate.Observe(work, 0.5);
    }
    EXPECT_NEAR(rate.Predict(work), 0.5, 0.01);
    rate.Observe(work, outlier);
    EXPECT_NEAR(rate.Predict(work), 0.5, 0.15) << "after " << outlier << " seconds";
  }
}

TEST(ExtractionRate, FastSmallReadsDoNotPromiseFastLargeOnes)
{
  const auto makeWork = [](double bytes)
  {
    ExtractionWork work;
    work.Blocks = work.BlocksRead = bytes / 1e5;
    work.ReadBytes = bytes;
    return work;
  };
  const auto fromMemory = [](const ExtractionWork& work) { return 1e-3 + 2e-10 * work.ReadBytes; };
  ExtractionRate rate;
  for (const double bytes : { 1e6, 2e6, 4e6, 8e6 })
  {
    rate.Observe(makeWork(bytes), fromMemory(makeWork(bytes)));
  }
  EXPECT_LT(rate.Predict(makeWork(8e6)), 0.01);
  EXPECT_GT(rate.Predict(makeWork(1e9)), 2) << "a disk reads some hundred MB in a second";
  rate.Observe(makeWork(1e9), fromMemory(makeWork(1e9)));
  EXPECT_LT(rate.Predict(makeWork(1e9)), 0.5) << "as much was read as fast";
}

TEST(ExtractionRate, OneObservationGivesTheSpeedOfTheMachine)
{
  ExtractionWork small;
  small.Blocks = 1000;
  small.SampleBytes = 1e7;
  small.Triangles = 1e5;
  ExtractionWork large = small;
  large.Blocks *= 50;
  large.SampleBytes *= 50;
  large.Triangles *= 50;
  for (const double factor : { 0.2, 1.0, 5.0 })
  {
    ExtractionRate rate;
    const double usual = rate.Predict(large);
    rate.Observe(small, factor * rate.Predict(small));
    EXPECT_NEAR(rate.Predict(large) / usual, factor, 0.35 * factor);
  }
}
