// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/ActiveBlocks.h"
#include "Storage/Store/BlockedVolume.h"

#include "Fixtures/BlocksByForce.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Storage/Record/BlockRecord.h"

#include <atomic>
#include <thread>

using namespace isosurface;

namespace
{

template <typename T>
void ExpectActiveEqualsBruteForce(
  const SampleVolume<T>& volume, const std::vector<std::vector<double>>& queries)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, 3));
  for (const std::vector<double>& isovalues : queries)
  {
    QueryStatistics statistics;
    const auto active = Require(FindActiveBlocks(*opened, { { 0, 0, isovalues } }, statistics));
    EXPECT_EQ(SortBlocks(active), FindBlocksByForce(volume, opened->GetBlockGrid(), isovalues));
    EXPECT_EQ(statistics.ActiveBlocks, active.size());
    EXPECT_LE(statistics.ActiveBlocks, statistics.IntervalsReported);
  }
}

} // namespace

TEST(BlockedVolumeQuery, ActiveBlocksEqualBruteForce)
{
  const double infinity = std::numeric_limits<double>::infinity();
  ExpectActiveEqualsBruteForce(MakeVolume<std::uint8_t>({ 60, 50, 40 }),
    { {}, { 3 }, { 3.5 }, { 50 }, { 0 }, { -1 }, { 255 }, { 256 }, { 1e300 }, { infinity },
      { -infinity }, { std::nan("") }, { 10, 90, 10, 60.5 }, { 104 }, { 103 } });
  ExpectActiveEqualsBruteForce(MakeVolume<double>({ 60, 50, 40 }),
    { { 3 }, { std::nextafter(3.0, 4.0) }, { 44.4, 5 }, { infinity }, { -infinity } });
  std::mt19937 random(2);
  ExpectActiveEqualsBruteForce(SampleVolume<float>({ 60, 50, 40 },
                                 [&](auto i, auto, auto) -> float
                                 {
                                   switch (random() % 20000)
                                   {
                                     case 0:
                                       return std::numeric_limits<float>::quiet_NaN();
                                     case 1:
                                       return std::numeric_limits<float>::infinity();
                                     case 2:
                                       return -std::numeric_limits<float>::infinity();
                                     default:
                                       return i < 20 ? -0.0f : 1.0f;
                                   }
                                 }),
    { { 0 }, { 1 }, { -5 }, { 2 }, { infinity }, { -infinity }, { 0.5 }, { 1e-60 } });
  const std::int64_t large = std::int64_t{ 1 } << 60;
  ExpectActiveEqualsBruteForce(SampleVolume<std::int64_t>({ 40, 20, 20 },
                                 [&](auto i, auto, auto) { return i < 20 ? large : large + 256; }),
    { { static_cast<double>(large) }, { static_cast<double>(large + 256) } });
}

TEST(BlockedVolumeQuery, ReadsActiveBlocksAndNothingElse)
{
  MemoryDisk disk;
  const auto opened =
    WriteAndOpen(disk, MakeVolume<std::uint16_t>({ 70, 60, 50 }), MakeSettings(16, 2));
  QueryStatistics statistics;
  const auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 50 } } }, statistics));
  ASSERT_GT(active.size(), 3u);
  EXPECT_EQ(disk.GetBytesRead("/blocks"), 0u);
  EXPECT_GT(statistics.TreePagesRead, 0u);
  // Beside page 0 of the two files of a kind, which opening reads in one or two steps.
  const auto expectPages = [&](const std::string& name, std::uint64_t pages)
  {
    EXPECT_GE(disk.GetBytesRead(name), (pages + 2) * 4096);
    EXPECT_LE(disk.GetBytesRead(name), (pages + 4) * 4096);
  };
  expectPages(".tree", statistics.TreePagesRead);
  expectPages("/directory", statistics.DirectoryPagesRead);
  EXPECT_GE(statistics.QuerySeconds, 0);

  std::uint64_t bytes = 0;
  const std::uint64_t readsBefore = disk.GetReads();
  for (const BlockReference& block : active)
  {
    ASSERT_TRUE(opened->ReadBlock(block, 0, 0, 0, statistics).IsOk());
    bytes += BlockRecordLayout(opened->GetBlockGrid(), block.Block, { ValueType::UInt16 }).Size;
  }
  EXPECT_EQ(statistics.BlocksRead, active.size());
  EXPECT_EQ(disk.GetReads() - readsBefore, active.size());
  EXPECT_EQ(statistics.BytesRead, bytes);
  EXPECT_EQ(disk.GetBytesRead("/blocks"), bytes);
  EXPECT_EQ(statistics.BlockCacheHits, 0u);
  for (const BlockReference& block : active)
  {
    ASSERT_TRUE(opened->ReadBlock(block, 0, 0, 0, statistics).IsOk());
  }
  EXPECT_EQ(statistics.BlocksRead, active.size());
  EXPECT_EQ(statistics.BlockCacheHits, active.size());
  EXPECT_EQ(disk.GetBytesRead("/blocks"), bytes);

  // Another reader of the same file finds the blocks in the same cache.
  const auto cache = std::make_shared<BlockCache>(std::uint64_t{ 1 } << 28);
  const auto countHits = [&](BlockedVolume& reader)
  {
    QueryStatistics asked;
    EXPECT_TRUE(reader.ReadBlock(active[0], 0, 0, 0, asked).IsOk());
    return asked.BlockCacheHits;
  };
  auto first = *BlockedVolume::Open(VolumePath, disk, cache);
  EXPECT_EQ(countHits(*first), 0u);
  auto second = *BlockedVolume::Open(VolumePath, disk, cache);
  EXPECT_EQ(countHits(*second), 1u);
  first.reset();
  EXPECT_EQ(countHits(*second), 1u);

  // The blocks go with the last of them.
  second.reset();
  EXPECT_EQ(cache->GetSize(), 0u);
  EXPECT_EQ(countHits(**BlockedVolume::Open(VolumePath, disk, cache)), 0u);
}

TEST(BlockedVolumeQuery, RefusesArgumentsOutOfRange)
{
  MemoryDisk disk;
  const auto opened =
    WriteAndOpen(disk, MakeVolume<std::uint16_t>({ 20, 20, 20 }), MakeSettings(16, 2));
  QueryStatistics statistics;
  const auto expectInvalid = [](const Status& status)
  { EXPECT_EQ(status.GetCode(), StatusCode::InvalidArgument) << status.GetMessage(); };
  expectInvalid(FindActiveBlocks(*opened, { { 1, 0, { 1 } } }, statistics).GetStatus());
  expectInvalid(FindActiveBlocks(*opened, { { 0, 1, { 1 } } }, statistics).GetStatus());
  expectInvalid(FindActiveBlocks(*opened, { { 0, 0, { 1 } }, 1, 1 }, statistics).GetStatus());
  expectInvalid(FindActiveBlocks(*opened, { { 0, 0, { 1 } }, -1, 2 }, statistics).GetStatus());
  expectInvalid(opened->ReadBlock({ 0, 0, 0 }, 0, 0, 5, statistics).GetStatus());
  expectInvalid(opened->ReadBlock({ 0, 2, 0 }, 0, 0, 0, statistics).GetStatus());
  expectInvalid(opened->ReadBlock({ 8, 0, 0 }, 0, 0, 0, statistics).GetStatus());
  EXPECT_FALSE(opened->ReadBlock({ 0, 0, 99 }, 0, 0, 0, statistics).IsOk());
  EXPECT_EQ(
    BlockedVolume::Open("/data/other.bvol", disk).GetStatus().GetCode(), StatusCode::NotFound);
}

TEST(BlockedVolumeQuery, ReportsThatTheVolumeWasRewritten)
{
  const auto volume = MakeVolume<std::uint8_t>({ 40, 40, 40 });
  for (const bool isRemovedFirst : { false, true })
  {
    MemoryDisk disk;
    const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, 2));
    QueryStatistics statistics;
    // Store 0 is open, store 1 not yet.
    ASSERT_TRUE(FindActiveBlocks(*opened, { { 0, 0, { 50 } }, 0, 2 }, statistics).IsOk());
    if (isRemovedFirst)
    {
      // Then the new generation has the number of the old one.
      ASSERT_TRUE(disk.RemoveAll(VolumePath).IsOk());
      ASSERT_TRUE(disk.RemoveAll(HidePath(VolumePath + ".stores")).IsOk());
    }
    WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 40, 40, 40 }, 9), MakeSettings(16, 2));
    const auto share = FindActiveBlocks(*opened, { { 0, 0, { 50 } }, 1, 2 }, statistics);
    ExpectMessage(share.GetStatus(), "reload");
    const auto active = FindActiveBlocks(*opened, { { 0, 0, { 50 } } }, statistics);
    ExpectMessage(active.GetStatus(), "reload");
    EXPECT_NE(OpenVolume(disk), nullptr);
  }
}

TEST(BlockedVolumeQuery, IsSafeForManyThreads)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 70, 60, 50 }), MakeSettings(16, 3));
  const auto opened = OpenVolume(disk, 100000); // blocks come and go
  ASSERT_NE(opened, nullptr);
  std::atomic<int> wrong{ 0 };
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread)
  {
    threads.emplace_back(
      [&, thread]
      {
        QueryStatistics statistics;
        for (int round = 0; round < 3; ++round)
        {
          const auto active =
            FindActiveBlocks(*opened, { { 0, 0, { 20.0 + 10 * round, 60 } } }, statistics);
          wrong += !active.IsOk();
          for (std::size_t index = 0; active.IsOk() && index < active->size(); ++index)
          {
            const auto block =
              opened->ReadBlock((*active)[index], 0, 0, (round + thread) % 2, statistics);
            wrong += !block.IsOk() || (*block)->Block != (*active)[index].Block;
          }
          wrong += !opened->GetSpectrum(0, 0).IsOk();
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}
