// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/LevelSamples.h"
#include "Fixtures/VolumeOnDisk.h"

#include <random>

using namespace isosurface;

TEST(LevelSamples, EveryStepOfAnyBoxHasTheSamplesThatWereWritten)
{
  std::mt19937 random(5);
  const auto choose = [&](std::int64_t low, std::int64_t high)
  { return std::uniform_int_distribution<std::int64_t>(low, high)(random); };
  for (const Index3& size :
    { Index3{ 70, 33, 50 }, Index3{ 17, 40, 1 }, Index3{ 3, 2, 66 }, Index3{ 1, 1, 1 } })
  {
    const auto written = MakeVolume<std::int16_t>(size);
    MemoryDisk disk;
    const auto volume = WriteAndOpen(disk, written, MakeSettings(16, 3));
    for (int level = 0; level < volume->GetNumberOfLevels(); ++level)
    {
      const auto samples = Require(LevelSamples::Open(volume, 0, level));
      for (int repeat = 0; repeat < 20; ++repeat)
      {
        VertexBox box = samples->GetBox();
        Index3 step{ 1, 1, 1 };
        Index3 count = box.GetSize();
        for (std::size_t axis = 0; axis < 3 && repeat > 0; ++axis)
        {
          const std::int64_t last = count[axis] - 1;
          box.Low[axis] = choose(0, last);
          box.High[axis] = choose(box.Low[axis], last) + 1;
          step[axis] = choose(1, 20);
          count[axis] = (box.High[axis] - box.Low[axis] + step[axis] - 1) / step[axis];
        }
        constexpr std::int16_t untouched = 12345;
        // Every other one, as the components of an array of two.
        std::vector<std::int16_t> values(
          static_cast<std::size_t>(2 * count[0] * count[1] * count[2]), untouched);
        QueryStatistics statistics;
        const Status status = samples->Read(0, box, step, 2, values.data(), 2, statistics);
        ASSERT_TRUE(status.IsOk()) << status.GetMessage();
        auto read = values.begin();
        std::size_t wrong = 0;
        VisitVertices({ { 0, 0, 0 }, count },
          [&](const Index3& at)
          {
            Index3 vertex{};
            for (std::size_t axis = 0; axis < 3; ++axis)
            {
              vertex[axis] = (box.Low[axis] + at[axis] * step[axis]) << level;
            }
            wrong += *read++ != written.At(vertex[0], vertex[1], vertex[2]);
            wrong += *read++ != untouched;
          });
        EXPECT_EQ(wrong, 0u);
      }
    }
  }
}

TEST(LevelSamples, OnlyBlocksWithAChosenVertexAreRead)
{
  MemoryDisk disk;
  const auto volume =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 100, 100, 100 }), MakeSettings(16, 1));
  const auto samples = Require(LevelSamples::Open(volume, 0, 0));
  std::vector<std::uint8_t> values(100 * 100);
  const auto countBlocks = [&](const VertexBox& box, const Index3& step)
  {
    QueryStatistics statistics;
    EXPECT_TRUE(samples->Read(0, box, step, 1, values.data(), 1, statistics).IsOk());
    return statistics.BlocksRead + statistics.BlockCacheHits;
  };
  EXPECT_EQ(countBlocks({ { 0, 0, 40 }, { 100, 100, 41 } }, { 1, 1, 1 }), 7u * 7u);
  EXPECT_EQ(countBlocks({ { 0, 0, 0 }, { 100, 100, 100 } }, { 48, 48, 48 }), 27u);
  EXPECT_EQ(countBlocks({ { 99, 99, 99 }, { 100, 100, 100 } }, { 1, 1, 1 }), 1u);
  EXPECT_EQ(countBlocks({ { 5, 5, 5 }, { 5, 9, 9 } }, { 1, 1, 1 }), 0u) << "an empty box";
}
