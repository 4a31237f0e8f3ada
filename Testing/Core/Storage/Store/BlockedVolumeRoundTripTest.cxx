// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include "Fixtures/VolumeOnDisk.h"

#include <limits>

using namespace isosurface;

namespace
{

/// Expects every block at every level to be the subsampled volume, of as many bytes as estimated.
template <typename T>
void ExpectSamplesReadBack(
  BlockedVolume& opened, const SampleVolume<T>& volume, std::size_t array = 0)
{
  QueryStatistics statistics;
  for (int level = 0; level < opened.GetNumberOfLevels(); ++level)
  {
    EXPECT_EQ(opened.EstimateBytes(array, level),
      isosurface::ExpectReadsBack(opened, volume, level, statistics, array));
  }
}

template <typename T>
class BlockedVolumeOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(BlockedVolumeOfType, AllValueTypes, );

} // namespace

TYPED_TEST(BlockedVolumeOfType, ReadsBackWhatWasWritten)
{
  using T = TypeParam;
  std::mt19937_64 random(4);
  const SampleVolume<T> volume({ 37, 21, 34 },
    [&](auto...)
    {
      return std::is_floating_point_v<T> ? static_cast<T>(random() % 1000) / T(7)
                                         : static_cast<T>(random());
    });
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, 3), 2);
  ExpectSamplesReadBack(*opened, volume);
  KeyRange range;
  for (const T value : volume.Samples)
  {
    range.Minimum = std::min(range.Minimum, MakeValueKey(value));
    range.Maximum = std::max(range.Maximum, MakeValueKey(value));
  }
  EXPECT_EQ(opened->GetHeader().TimeSteps[0].Ranges[0].Minimum, range.Minimum);
  EXPECT_EQ(opened->GetHeader().TimeSteps[0].Ranges[0].Maximum, range.Maximum);
}

TEST(BlockedVolumeRoundTrip, HoldsForAnyDimensionsAndBlockSizes)
{
  const Index3 sizes[] = { { 1, 1, 1 }, { 2, 1, 1 }, { 1, 2, 3 }, { 3, 3, 3 }, { 17, 17, 17 },
    { 18, 16, 15 }, { 33, 1, 50 }, { 65, 65, 2 }, { 66, 40, 3 }, { 70, 35, 67 }, { 129, 5, 5 } };
  for (const Index3& size : sizes)
  {
    for (const int blockSize : { 16, 32, 64 })
    {
      SCOPED_TRACE(std::to_string(size[0]) + "x" + std::to_string(size[1]) + "x" +
        std::to_string(size[2]) + ", blocks of " + std::to_string(blockSize));
      const auto volume = MakeVolume<std::uint16_t>(size);
      MemoryDisk disk;
      const auto opened =
        WriteAndOpen(disk, volume, MakeSettings(blockSize, 2), 3, OverlappingColumns);
      EXPECT_EQ(opened->GetHeader().Grid, MakeGeometry(size));
      ExpectSamplesReadBack(*opened, volume);
    }
  }
}

TEST(BlockedVolumeRoundTrip, HoldsForSeveralArrays)
{
  const auto first = MakeVolume<std::uint8_t>({ 40, 37, 20 });
  const auto second = MakeVolume<double>({ 40, 37, 20 }, 5);
  MemoryDisk disk;
  for (const int ranks : { 1, 3 })
  {
    ThreadCommunicator::Run(ranks,
      [&](Communicator& communicator)
      {
        const VertexBox box = SlabOfEach(communicator.GetRank(), ranks, first.GetDimensions());
        const PieceOfVolume<std::uint8_t> firstPart(first, box);
        const PieceOfVolume<double> secondPart(second, box);
        const auto result =
          BlockedVolumeWriter(communicator, disk)
            .Write(VolumePath, MakeGeometry(first.GetDimensions()),
              { { "bytes", ValueType::UInt8 }, { "r\xC3\xB6ntgen \"x\"", ValueType::Float64 } },
              { box, { firstPart.View, secondPart.View } }, MakeSettings(32, 2));
        ASSERT_TRUE(result.IsOk()) << result.GetStatus().GetMessage();
      });
    const auto opened = OpenVolume(disk);
    EXPECT_EQ(opened->GetHeader().FindArray("r\xC3\xB6ntgen \"x\""), std::size_t{ 1 });
    EXPECT_FALSE(opened->GetHeader().FindArray("nothing").has_value());
    ExpectSamplesReadBack(*opened, first, 0);
    ExpectSamplesReadBack(*opened, second, 1);
  }
}

TEST(BlockedVolumeRoundTrip, HoldsForNaNAndInfinities)
{
  const float infinity = std::numeric_limits<float>::infinity();
  const SampleVolume<float> volume({ 35, 20, 20 },
    [&](auto i, auto, auto k) -> float
    {
      return i > 17 ? std::numeric_limits<float>::quiet_NaN()
        : k == 3    ? infinity
        : k == 4    ? -infinity
                    : static_cast<float>(i) - 4.5f;
    });
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, 2), 2);
  ExpectSamplesReadBack(*opened, volume);
  EXPECT_EQ(opened->GetHeader().TimeSteps[0].Ranges[0].Minimum, MakeValueKey(-4.5f));
  EXPECT_EQ(opened->GetHeader().TimeSteps[0].Ranges[0].Maximum, MakeValueKey(12.5f));

  const SampleVolume<float> nothing({ 5, 5, 5 }, [&](auto...) { return std::nanf(""); });
  const auto reopened = WriteAndOpen(disk, nothing, MakeSettings(16, 2));
  EXPECT_TRUE(reopened->GetHeader().TimeSteps[0].Ranges[0].IsEmpty());
  ExpectSamplesReadBack(*reopened, nothing);
}

TEST(BlockedVolumeRoundTrip, ReadsACoarseLevelAsAShortPrefix)
{
  MemoryDisk disk;
  const auto opened =
    WriteAndOpen(disk, MakeVolume<std::uint16_t>({ 129, 129, 129 }), MakeSettings(64, 1));
  std::uint64_t finer = 0;
  for (int level = 0; level < 4; ++level)
  {
    QueryStatistics statistics;
    const auto blocks = Require(opened->ListBlocks(0, statistics, level));
    for (const BlockReference& block : blocks)
    {
      ASSERT_TRUE(opened->ReadBlock(block, 0, 0, level, statistics).IsOk());
    }
    EXPECT_EQ(statistics.BlocksRead, blocks.size());
    if (level > 0)
    {
      EXPECT_LT(statistics.BytesRead, finer / 5);
    }
    finer = statistics.BytesRead;
  }
}

TEST(BlockedVolumeRoundTrip, EstimatesBytesOfBillionsOfBlocksWithoutVisitingThem)
{
  BlockedVolumeHeader header;
  header.Grid.Extent = { 0, (std::int64_t{ 1 } << 35) - 1, 0, 0, 0, 0 };
  header.BlockSize = 16;
  header.Arrays = { { "density", ValueType::UInt16 } };
  TimeStepDescription step;
  step.Folder = "000001";
  step.Ranges = { KeyRange{} };
  step.Stores = { { std::uint64_t{ 1 } << 31, 0, 0 } };
  header.TimeSteps = { step };
  const std::string text = header.Format();
  MemoryDisk disk;
  ASSERT_TRUE(disk.MakeDirectories(HidePath(VolumePath + ".stores")).IsOk());
  ASSERT_TRUE(disk.CreateForWriting(VolumePath).IsOk());
  disk.GetFile(VolumePath) = MemoryDisk::Bytes(text.begin(), text.end());
  const auto opened = OpenVolume(disk);
  // 17 vertices and two ghosts a block; the first has one ghost, the last one, and a vertex less.
  EXPECT_EQ(opened->EstimateBytes(0, 0), 2 * ((std::uint64_t{ 19 } << 31) - 3));
  // Two vertices and two ghosts; the last block has one of the vertices.
  EXPECT_EQ(opened->EstimateBytes(0, 4), 2 * ((std::uint64_t{ 4 } << 31) - 4));
}
