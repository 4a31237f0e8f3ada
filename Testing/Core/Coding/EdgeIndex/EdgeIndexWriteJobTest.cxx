// SPDX-License-Identifier: BSD-3-Clause
// Ranks that write one file together write the one that a single writer does.
#include "Fixtures/CodedVolumes.h"

#include "Fixtures/LongTests.h"
#include "Fixtures/MemoryDisk.h"
#include "Fixtures/ThreadCommunicator.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Fixtures/EdgeIndexFileWriter.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

using namespace isosurface;

namespace
{

const std::string JobPath = "/data/surface.eix";

// Which rank has a block of a volume, of so many blocks.
using Deal = int (*)(std::size_t block, std::size_t blocks, int ranks);

int DealInTurn(std::size_t block, std::size_t, int ranks)
{
  return static_cast<int>(block) % ranks;
}
int DealSlabs(std::size_t block, std::size_t blocks, int ranks)
{
  return static_cast<int>(block * static_cast<std::size_t>(ranks) / blocks);
}
int DealToLast(std::size_t, std::size_t, int ranks)
{
  return ranks - 1;
}

// Some blocks of another source; fails at a block, counted over all sources.
class PartOfSource : public BlockSource
{
public:
  PartOfSource(BlockSource& whole, int rank, int ranks, Deal deal)
    : Whole(whole)
  {
    for (std::size_t block = 0; block < whole.GetNumberOfBlocks(); ++block)
    {
      if (deal(block, whole.GetNumberOfBlocks(), ranks) == rank)
      {
        this->Numbers.push_back(static_cast<std::int64_t>(block));
      }
    }
  }
  std::size_t GetNumberOfBlocks() const override { return this->Numbers.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Whole.GetLatticeCoordinates(this->Get(block));
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Whole.GetVertices(this->Get(block));
  }
  ValueType GetValueType() const override { return this->Whole.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    if (this->Get(block) == this->FaultyBlock)
    {
      return Status(StatusCode::Corrupt, "/data/volume: block is damaged");
    }
    return this->Whole.Acquire(this->Get(block));
  }

  std::vector<std::int64_t> Numbers;
  std::size_t FaultyBlock = static_cast<std::size_t>(-1);

private:
  std::size_t Get(std::size_t block) const
  {
    return static_cast<std::size_t>(this->Numbers[block]);
  }
  BlockSource& Whole;
};

template <typename T>
class Writing
{
public:
  Writing()
    : Volume(MakeWaves<T>({ 70, 40, 34 }, 0.2))
    , Header(MakeHeader(Volume, { 120.5, 150 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working))
  {
    this->Header.PreviewLevel = 1;
  }

  MemoryDisk::Bytes WriteAlone()
  {
    MemoryDisk disk;
    static_cast<void>(disk.MakeDirectories("/data"));
    TestBlockSource<T> source(this->Volume, 16);
    const Status status = WriteEdgeIndexFile(disk, JobPath, this->Header, source, 1);
    EXPECT_TRUE(status.IsOk()) << status.GetMessage();
    return disk.GetFile(JobPath);
  }

  /// Every rank's outcome.
  std::vector<Status> WriteTogether(MemoryDisk& disk, int ranks, Deal deal,
    EdgeIndexWriteJob::Settings settings, std::size_t faultyBlock = static_cast<std::size_t>(-1),
    const Progress& progressOfLast = {})
  {
    static_cast<void>(disk.MakeDirectories("/data"));
    return ThreadCommunicator::Collect(ranks,
      [&](Communicator& communicator)
      {
        TestBlockSource<T> whole(this->Volume, 16);
        PartOfSource source(whole, communicator.GetRank(), ranks, deal);
        source.FaultyBlock = faultyBlock;
        EdgeIndexWriteJob job(
          communicator, disk, JobPath, this->Header, source, source.Numbers, settings);
        const auto written =
          job.Run(communicator.GetRank() == ranks - 1 ? progressOfLast : Progress());
        EXPECT_TRUE(!written.IsOk() || written->Bytes == disk.GetFile(JobPath).size());
        return written.GetStatus();
      });
  }

  SampleVolume<T> Volume;
  EdgeIndexHeader Header;
};

} // namespace

TEST(EdgeIndexWriteJob, RanksThreadsAndMemoryDoNotChangeTheBytes)
{
  Writing<std::uint8_t> writing;
  const MemoryDisk::Bytes expected = writing.WriteAlone();
  for (const Deal deal : { DealInTurn, DealSlabs, DealToLast })
  {
    for (const int ranks : GetNumbersOfRanks())
    {
      MemoryDisk disk;
      // Little enough memory for many rounds.
      const EdgeIndexWriteJob::Settings settings = { ranks % 2 + 1,
        ranks == 3 ? std::uint64_t{ 1 } << 20 : 500 };
      for (const Status& status : writing.WriteTogether(disk, ranks, deal, settings))
      {
        ASSERT_TRUE(status.IsOk()) << status.GetMessage();
      }
      EXPECT_EQ(disk.GetFile(JobPath), expected) << ranks << " ranks";
      EXPECT_EQ(disk.GetFiles().size(), 1u) << "something was left beside the file";
    }
  }
}

TEST(EdgeIndexWriteJob, PreviewsAreWhereASingleWriterPutsThem)
{
  // More than what is kept back of a preview at a time.
  Writing<float> writing;
  writing.Volume = MakeWaves<float>({ 145, 145, 145 }, 1.5);
  writing.Header = MakeHeader(
    writing.Volume, { -0.1, 0, 0.1, 0.2 }, EdgeIndexMode::Bounded, EdgeIndexProfile::Working);
  writing.Header.Settings.MaximumError = 0.5;
  writing.Header.PreviewLevel = 1;
  writing.Header.PreviewMaximumError = 0.00002;
  const MemoryDisk::Bytes expected = writing.WriteAlone();
  MemoryDisk disk;
  static_cast<void>(writing.WriteTogether(disk, 2, DealInTurn, { 2, std::uint64_t{ 1 } << 18 }));
  EXPECT_EQ(disk.GetFile(JobPath), expected);
  const auto file = Require(EdgeIndexFile::Open(disk, JobPath));
  std::uint64_t preview = 0;
  int changes = 0;
  bool wasPreview = false;
  for (const EdgeIndexEntry& entry : file->GetEntries())
  {
    preview += entry.Block.IsPreview ? entry.Size : 0;
    changes += entry.Block.IsPreview != wasPreview ? 1 : 0;
    wasPreview = entry.Block.IsPreview;
  }
  EXPECT_GT(preview, MaximumEdgeIndexPreviewBytes) << "the test is of no use";
  EXPECT_LE(changes, 2 * static_cast<int>(preview / MaximumEdgeIndexPreviewBytes) + 2);
}

TEST(EdgeIndexWriteJob, AFailedRankLeavesTheOldFileAndAllRanksReportIt)
{
  Writing<std::uint8_t> writing;
  const MemoryDisk::Bytes old = { 1, 2, 3 };
  for (const int ranks : { 1, 3 })
  {
    MemoryDisk disk;
    static_cast<void>(disk.MakeDirectories("/data"));
    const auto file = disk.CreateForWriting(JobPath);
    ASSERT_TRUE((*file)->Append(old.data(), old.size()).IsOk());
    for (const Status& status : writing.WriteTogether(disk, ranks, DealInTurn, { 2, 500 }, 31))
    {
      EXPECT_FALSE(status.IsOk());
      ExpectMessage(status, "block is damaged");
    }
    EXPECT_EQ(disk.GetFile(JobPath), old);
    EXPECT_EQ(disk.GetFiles().size(), 1u);
  }
}

TEST(EdgeIndexWriteJob, WarnsBeforeTheFirstByteIfTheDiskHasNoRoom)
{
  Writing<std::uint8_t> writing;
  const std::uint64_t written = writing.WriteAlone().size();
  // All blocks are encoded by then, or a few.
  for (const std::uint64_t memory : { 1 << 20, 1000 })
  {
    for (const bool isSmall : { false, true })
    {
      MemoryDisk disk;
      disk.SetFreeBytes(isSmall ? written / 2 : written * 2);
      std::vector<std::string> warnings;
      std::size_t bytes = 0;
      EdgeIndexWriteJob::Settings settings = { 1, memory };
      settings.Warn = [&](const std::string& warning)
      {
        warnings.push_back(warning);
        bytes = disk.GetFile(EdgeIndexFileWriter::GetPartialPath(JobPath)).size();
      };
      for (const Status& status : writing.WriteTogether(disk, 3, DealInTurn, settings))
      {
        EXPECT_TRUE(status.IsOk()) << "it is only a warning";
      }
      EXPECT_EQ(bytes, 0U);
      EXPECT_EQ(warnings.size(), isSmall ? 1U : 0U);
      for (const std::string& warning : warnings)
      {
        EXPECT_EQ(
          warning, std::string(JobPath) + ": takes about 1 MiB, but its disk has room for 0 MiB");
      }
    }
  }
}

TEST(EdgeIndexWriteJob, AFullDiskLeavesTheOldFileAndAllRanksReportIt)
{
  Writing<std::uint8_t> writing;
  MemoryDisk whole;
  static_cast<void>(writing.WriteTogether(whole, 2, DealInTurn, { 1, 500 }));
  const std::uint64_t writes = whole.GetWrites();
  for (std::uint64_t write = 1; write < writes; write += 1 + writes / 12)
  {
    MemoryDisk disk;
    static_cast<void>(disk.MakeDirectories("/data"));
    disk.FailFromWrite(write);
    for (const Status& status : writing.WriteTogether(disk, 2, DealInTurn, { 1, 500 }))
    {
      EXPECT_FALSE(status.IsOk()) << "write " << write << " of " << writes;
    }
    EXPECT_FALSE(disk.Exists(EdgeIndexFileWriter::GetPartialPath(JobPath)));
  }
}

TEST(EdgeIndexWriteJob, StopsWhenProgressReturnsFalse)
{
  Writing<std::uint8_t> writing;
  MemoryDisk disk;
  for (const Status& status : writing.WriteTogether(disk, 2, DealInTurn, { 1, 500 },
         static_cast<std::size_t>(-1), [](double share) { return share < 0.5; }))
  {
    EXPECT_EQ(status.GetCode(), StatusCode::Aborted);
  }
  EXPECT_TRUE(disk.GetFiles().empty());
}
