// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/Require.h"
#include "Fixtures/ResealedPages.h"
#include "Ground/Base/Checksum.h"
#include "IntervalSets.h"

using namespace isosurface;

namespace
{

constexpr std::size_t SmallMemory = ExternalIntervalTreeBuilder::MinimumMemoryLimit;

} // namespace

TEST(ExternalIntervalTreeBuilder, TheBytesDependOnTheSetOfIntervalsOnly)
{
  for (const IntervalSet& set : MakeIntervalSets())
  {
    IntervalVector intervals = set.MakeAll(20000);
    // The same payload may come with several intervals, and the same interval twice.
    for (std::size_t index = 0; index < 100; ++index)
    {
      intervals[index].Payload = 7;
      intervals[index + 100] = intervals[index];
    }
    MemoryDisk disk;
    ASSERT_TRUE(WriteTree(disk, "a", intervals).IsOk());
    EXPECT_EQ(disk.GetCreatedFiles(), 1u) << set.Name << ": a temporary file for a small set";
    std::shuffle(intervals.begin(), intervals.end(), std::mt19937_64(5));
    ASSERT_TRUE(WriteTree(disk, "b", intervals, SmallMemory).IsOk());
    EXPECT_GT(disk.GetCreatedFiles(), 2u) << set.Name << ": the test wants to see temporary files";
    EXPECT_EQ(disk.GetFile("a"), disk.GetFile("b")) << set.Name;
    EXPECT_EQ(disk.GetFiles().size(), 2u) << set.Name << ": a temporary file is left";
  }
}

TEST(ExternalIntervalTreeBuilder, TheFormatHasNotChanged)
{
  // Files are kept for years. Who changes their bytes raises IntervalTreeFormat::Version (or
  // PagedFile::FormatVersion), reads the old ones still, and changes the specification.
  IntervalVector intervals;
  for (std::uint32_t index = 0; index < 10000; ++index)
  {
    const ValueKey minimum = std::uint64_t(index) * 7919 % 10007;
    intervals.push_back({ minimum, minimum + (std::uint64_t(index) * 104729 % 1000), index });
  }
  MemoryDisk disk;
  ASSERT_TRUE(WriteTree(disk, "tree", intervals).IsOk());
  // All but the sums, which early writers did not know.
  auto& bytes = disk.GetFile("tree");
  RemoveSums(bytes);
  EXPECT_EQ(ComputeChecksum(bytes.data(), bytes.size()), 17274510250033190819u);
}

TEST(ExternalIntervalTreeBuilder, IntervalsThatFitInMemoryNeedNoTemporaryFile)
{
  for (const IntervalSet& set : MakeIntervalSets())
  {
    MemoryDisk disk;
    ASSERT_TRUE(WriteTree(disk, "tree", set.MakeAll(SmallMemory / 240 - 1), SmallMemory).IsOk());
    EXPECT_EQ(disk.GetCreatedFiles(), 1u) << set.Name;
  }
}

TEST(ExternalIntervalTreeBuilder, AFailingDiskGivesAnErrorAndLeavesNoFile)
{
  const IntervalVector intervals = MakeIntervalSets()[0].MakeAll(20000);
  MemoryDisk whole;
  ASSERT_TRUE(WriteTree(whole, "tree", intervals, SmallMemory).IsOk());
  const std::string before = "what was there before";
  for (const bool reads : { false, true })
  {
    const std::uint64_t operations = reads ? whole.GetReads() : whole.GetWrites();
    const std::uint64_t step = std::max<std::uint64_t>(1, operations / 50);
    for (std::uint64_t left = 0; left < operations;
         left += left + step < operations - 20 ? step : 1)
    {
      MemoryDisk disk;
      disk.SetFile("tree", MemoryDisk::Bytes(before.begin(), before.end()));
      reads ? disk.FailFromRead(left) : disk.FailFromWrite(left);
      const Status status = WriteTree(disk, "tree", intervals, SmallMemory);
      ASSERT_EQ(status.GetCode(), StatusCode::IoError) << left;
      ASSERT_NE(status.GetMessage().find("tree"), std::string::npos);
      ASSERT_EQ(disk.GetFiles().size(), 1u) << "after " << left << " operations a file is left";
      ASSERT_EQ(std::string(disk.GetFile("tree").begin(), disk.GetFile("tree").end()), before);
    }
  }
}

TEST(ExternalIntervalTreeBuilder, AnUnfinishedBuilderLeavesNoFile)
{
  MemoryDisk disk;
  {
    ExternalIntervalTreeBuilder builder(disk, "tree", SmallMemory);
    for (const KeyInterval& interval : MakeIntervalSets()[0].MakeAll(30000))
    {
      ASSERT_TRUE(builder.Add(interval).IsOk());
    }
    EXPECT_FALSE(disk.GetFiles().empty()) << "the test wants to see temporary files";
    for (const auto& file : disk.GetFiles())
    {
      EXPECT_EQ(file.first.substr(file.first.size() - 4), ".tmp");
    }
  }
  EXPECT_TRUE(disk.GetFiles().empty());
}

TEST(ExternalIntervalTreeBuilder, RejectsInvalidArguments)
{
  MemoryDisk disk;
  ExternalIntervalTreeBuilder builder(disk, "tree", SmallMemory);
  ASSERT_TRUE(builder.Add({ 1, 2, 3 }).IsOk());
  EXPECT_EQ(builder.Add({ 2, 1, 4 }).GetCode(), StatusCode::InvalidArgument);
  EXPECT_EQ(builder.Finish().GetCode(), StatusCode::InvalidArgument) << "the first error stays";
  EXPECT_TRUE(disk.GetFiles().empty());

  EXPECT_EQ(WriteTree(disk, "tree", {}, SmallMemory - 1).GetCode(), StatusCode::InvalidArgument);
  EXPECT_EQ(WriteTree(disk, "tree", {}, SmallMemory, 5000).GetCode(), StatusCode::InvalidArgument);
  EXPECT_TRUE(disk.GetFiles().empty());

  ExternalIntervalTreeBuilder twice(disk, "tree", SmallMemory);
  EXPECT_TRUE(twice.Finish().IsOk());
  EXPECT_EQ(twice.Finish().GetCode(), StatusCode::InvalidArgument);
  EXPECT_TRUE(disk.Exists("tree"));
}
