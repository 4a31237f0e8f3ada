// SPDX-License-Identifier: BSD-3-Clause
// Time steps that are appended to a volume one at a time.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/VolumeOnDisk.h"

#include <cmath>
#include <functional>
#include <utility>

using namespace isosurface;

namespace
{

const Index3 SizeOfSteps = { 40, 33, 20 };

SampleVolume<std::uint16_t> MakeStep(unsigned step)
{
  return MakeVolume<std::uint16_t>(SizeOfSteps, step + 1);
}

BlockedVolumeSettings MakeStepSettings(double time)
{
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.Time = time;
  settings.Append = true;
  return settings;
}

/// Appends step n at time n / 2.
void AppendStep(FileSystem& disk, unsigned step, int ranks = 1)
{
  WriteVolumeOk(disk, MakeStep(step), MakeStepSettings(0.5 * step), ranks);
}

/// Expects the steps 0, 1, ... with their own samples and trees.
void ExpectSteps(FileSystem& disk, unsigned count)
{
  const auto opened = OpenVolume(disk);
  ASSERT_EQ(opened->GetHeader().TimeSteps.size(), count);
  for (unsigned step = 0; step < count; ++step)
  {
    EXPECT_EQ(opened->GetHeader().TimeSteps[step].Time, 0.5 * step);
    const auto volume = MakeStep(step);
    QueryStatistics statistics;
    for (int level = 0; level < opened->GetNumberOfLevels(); ++level)
    {
      ExpectReadsBack(*opened, volume, level, statistics, 0, step);
      const auto spectrum = Require(opened->GetSpectrum(step, 0, level));
    }
  }
}

void ExpectRefused(FileSystem& disk, const BlockedVolumeSettings& settings, const std::string& part,
  const Index3& size = SizeOfSteps)
{
  for (const auto& result : WriteVolume(disk, MakeVolume<std::uint16_t>(size), settings, 2))
  {
    ExpectError(result.GetStatus(), StatusCode::InvalidArgument, VolumePath);
    ExpectMessage(result.GetStatus(), part);
  }
}

} // namespace

TEST(BlockedVolumeTimeSteps, AreAppendedWithoutTouchingThoseBefore)
{
  MemoryDisk disk;
  for (unsigned step = 0; step < 4; ++step)
  {
    const auto before = disk.Copy();
    AppendStep(disk, step, static_cast<int>(step) + 1);
    for (const auto& file : before)
    {
      if (file.first != VolumePath)
      {
        EXPECT_EQ(disk.GetFile(file.first), file.second) << file.first;
      }
    }
    ExpectSteps(disk, step + 1);
  }
}

TEST(BlockedVolumeTimeSteps, AreTheSameFilesOnAnyNumberOfRanks)
{
  MemoryDisk one;
  AppendStep(one, 0);
  AppendStep(one, 1);
  for (int ranks = 2; ranks <= 7; ++ranks)
  {
    MemoryDisk disk;
    AppendStep(disk, 0, ranks);
    AppendStep(disk, 1, 8 - ranks);
    EXPECT_EQ(disk.Copy(), one.Copy()) << ranks << " ranks";
  }
}

TEST(BlockedVolumeTimeSteps, AreReplacedAllTogetherByAWriteThatDoesNotAppend)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  AppendStep(disk, 1);
  WriteVolumeOk(disk, MakeStep(2), MakeSettings(16, 2));
  EXPECT_EQ(disk.List(HidePath(VolumePath + ".stores"))->size(), 1u);
  EXPECT_EQ(OpenVolume(disk)->GetHeader().TimeSteps.size(), 1u);
}

TEST(BlockedVolumeTimeSteps, StayInTheFolderOfRelease1WhichIsNotHidden)
{
  MemoryDisk disk;
  const std::string shown = VolumePath + ".stores";
  ASSERT_TRUE(disk.MakeDirectories(shown).IsOk());
  AppendStep(disk, 0);
  AppendStep(disk, 1);
  ExpectSteps(disk, 2);
  EXPECT_EQ(disk.List(shown)->size(), 2u);
  WriteVolumeOk(disk, MakeStep(2), MakeSettings(16, 2));
  EXPECT_EQ(disk.List(shown)->size(), 1u);
  EXPECT_FALSE(disk.Exists(HidePath(shown)));

  ASSERT_TRUE(disk.RemoveAll(shown).IsOk());
  const auto opened = BlockedVolume::Open(VolumePath, disk, nullptr);
  ExpectError(opened.GetStatus(), StatusCode::NotFound, VolumePath);
  ExpectMessage(opened.GetStatus(), HidePath(shown) + " is missing; copy or move both together");
}

TEST(BlockedVolumeTimeSteps, MustFitTheVolumeThatTheyAreAppendedTo)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  AppendStep(disk, 1);
  const auto before = disk.Copy();
  using Settings = BlockedVolumeSettings;
  const std::pair<std::string, std::function<void(Settings&)>> changes[] = {
    { "time 0.5, this one of time 0.5", [](Settings& s) { s.Time = 0.5; } },
    { "time 0.5, this one of time 0.25", [](Settings& s) { s.Time = 0.25; } },
    { "has no time", [](Settings& s) { s.Time.reset(); } },
    { "time", [](Settings& s) { s.Time = std::nan(""); } },
    { "16 cells", [](Settings& s) { s.BlockSize = 32; } },
    { "3 stores", [](Settings& s) { s.NumberOfStores = 4; } },
    { "greedy", [](Settings& s) { s.Distribution = DistributionMethod::Slab; } },
    { "seed 7", [](Settings& s) { s.RandomSeed = 8; } },
    { "compressed otherwise", [](Settings& s) { s.Compression.Codec = SegmentCodec::Zstd; } },
  };
  for (const auto& change : changes)
  {
    SCOPED_TRACE(change.first);
    BlockedVolumeSettings settings = MakeStepSettings(1);
    change.second(settings);
    ExpectRefused(disk, settings, change.first);
  }
  ExpectRefused(disk, MakeStepSettings(1), "extent", { 40, 33, 21 });
  for (const auto& result :
    WriteVolume(disk, MakeVolume<float>(SizeOfSteps), MakeStepSettings(1), 2))
  {
    ExpectMessage(result.GetStatus(), "types");
  }
  EXPECT_EQ(disk.Copy(), before);
}

TEST(BlockedVolumeTimeSteps, GoIntoAsManyStoresAsThereAreUnlessANumberIsGiven)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  BlockedVolumeSettings settings = MakeStepSettings(0.5);
  settings.NumberOfStores = 0;
  WriteVolumeOk(disk, MakeStep(1), settings, 2);
  ExpectSteps(disk, 2);
}

TEST(BlockedVolumeTimeSteps, CannotFollowAStepWithoutTime)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeStep(0), MakeSettings(16, 3));
  ExpectRefused(disk, MakeStepSettings(1), "has no time");
}

TEST(BlockedVolumeTimeSteps, CannotBeAppendedToADamagedHeader)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  disk.GetFile(VolumePath)[100] ^= 1;
  const auto before = disk.Copy();
  for (const auto& result : WriteVolume(disk, MakeStep(1), MakeStepSettings(1), 2))
  {
    EXPECT_EQ(result.GetStatus().GetCode(), StatusCode::Corrupt);
  }
  EXPECT_EQ(disk.Copy(), before);
}

TEST(BlockedVolumeTimeSteps, OfAnOpenVolumeStayReadableWhenAnotherIsAppended)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  const auto opened = OpenVolume(disk);
  AppendStep(disk, 1);
  QueryStatistics statistics;
  const auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 40.0 } } }, statistics));
  EXPECT_FALSE(active.empty());
}

TEST(BlockedVolumeTimeSteps, StayWhenALaterOneFailsAtAnyWrite)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  AppendStep(disk, 1);
  const auto before = disk.Copy();
  std::uint64_t failures = 0;
  // Only the very last write, which makes the new header's name durable, comes after the rename.
  for (bool isVisible = false; !isVisible; ++failures)
  {
    disk.FailFromWrite(failures);
    const auto results = WriteVolume(disk, MakeStep(2), MakeStepSettings(1), 2);
    disk.FailFromWrite(MemoryDisk::Never);
    EXPECT_FALSE(results[0].IsOk());
    EXPECT_FALSE(results[1].IsOk());
    isVisible = disk.Copy() != before;
    ExpectSteps(disk, isVisible ? 3 : 2);
  }
  EXPECT_GT(failures, 20u);
}

TEST(BlockedVolumeTimeSteps, BecomeVisibleTogetherWhenOneIsPublished)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeStep(7), MakeSettings(16, 2));
  const auto old = disk.GetFile(VolumePath);
  for (const int ranks : { 1, 3 })
  {
    ThreadCommunicator::Run(ranks,
      [&](Communicator& communicator)
      {
        BlockedVolumeWriter writer(communicator, disk);
        for (unsigned step = 0; step < 3; ++step)
        {
          const auto volume = MakeStep(step);
          const VertexBox box = SlabOfEach(communicator.GetRank(), ranks, SizeOfSteps);
          const PieceOfVolume<std::uint16_t> part(volume, box);
          BlockedVolumeSettings settings = MakeStepSettings(0.5 * step);
          settings.Append = step > 0;
          settings.Publish = step == 2;
          if (ranks == 1)
          {
            EXPECT_EQ(disk.GetFile(VolumePath), old);
          }
          const auto written = writer.Write(VolumePath, MakeGeometry(SizeOfSteps),
            { { "density", ValueType::UInt16 } }, VolumePiece{ box, { part.View } }, settings);
          ASSERT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
        }
      });
    ExpectSteps(disk, 3);
    EXPECT_EQ(disk.List(HidePath(VolumePath + ".stores"))->size(), 3u);
  }
}

TEST(BlockedVolumeTimeSteps, NeverPublishedAreRemoved)
{
  MemoryDisk disk;
  AppendStep(disk, 0);
  const auto before = disk.Copy();
  SerialCommunicator serial;
  const auto volume = MakeStep(1);
  const VolumePiece piece = { { { 0, 0, 0 }, SizeOfSteps }, { volume.GetView() } };
  const std::vector<ArrayDescription> arrays = { { "density", ValueType::UInt16 } };
  BlockedVolumeSettings settings = MakeStepSettings(1);
  settings.Publish = false;
  {
    BlockedVolumeWriter writer(serial, disk);
    ASSERT_TRUE(
      writer.Write(VolumePath, MakeGeometry(SizeOfSteps), arrays, piece, settings).IsOk());
    EXPECT_NE(disk.Copy(), before);
  }
  EXPECT_EQ(disk.Copy(), before);
  BlockedVolumeWriter writer(serial, disk);
  ASSERT_TRUE(writer.Write(VolumePath, MakeGeometry(SizeOfSteps), arrays, piece, settings).IsOk());
  // A later one fails, since its time is not above.
  settings.Publish = true;
  EXPECT_FALSE(writer.Write(VolumePath, MakeGeometry(SizeOfSteps), arrays, piece, settings).IsOk());
  EXPECT_EQ(disk.Copy(), before);
}
