// SPDX-License-Identifier: BSD-3-Clause
// The state of a volume on disk after the process that writes it was killed, or refused by the
// system, or takes more memory than it may. Writers run in processes of their own.
#include "Fixtures/LongTests.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Formats/Plain/RawVolume.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "Storage/Writing/GenerationFolder.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <random>
#include <string>

#include <csignal>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

using Clock = std::chrono::steady_clock;

/// A folder of its own, removed at the end.
class BlockedVolumeCrash : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Folder = ::testing::TempDir() + "isosurface-crash-" + std::to_string(::getpid());
    ASSERT_TRUE(this->Files.RemoveAll(this->Folder).IsOk());
    ASSERT_TRUE(this->Files.MakeDirectories(this->Folder).IsOk());
    this->Path = this->Folder + "/volume.bvol";
  }
  void TearDown() override { ASSERT_TRUE(this->Files.RemoveAll(this->Folder).IsOk()); }

  Status Write(const SampleVolume<std::uint8_t>& volume, const Progress& progress = {},
    SegmentCodec codec = SegmentCodec::None)
  {
    BlockedVolumeSettings settings = MakeSettings(16, 5);
    settings.Compression.Codec = codec;
    return this->Write(volume, settings, progress);
  }
  Status Append(const SampleVolume<std::uint8_t>& volume, double time)
  {
    BlockedVolumeSettings settings = MakeSettings(16, 5);
    settings.Time = time;
    settings.Append = true;
    return this->Write(volume, settings);
  }
  Status Write(const SampleVolume<std::uint8_t>& volume, const BlockedVolumeSettings& settings,
    const Progress& progress = {})
  {
    SerialCommunicator serial;
    return BlockedVolumeWriter(serial)
      .Write(this->Path, MakeGeometry(volume.GetDimensions()), { { "density", ValueType::UInt8 } },
        VolumePiece{ { { 0, 0, 0 }, volume.GetDimensions() }, { volume.GetView() } }, settings,
        progress)
      .GetStatus();
  }

  /// Whether a time step of the volume at the path has exactly the samples of `volume`.
  bool Holds(const SampleVolume<std::uint8_t>& volume, std::size_t step = 0)
  {
    const auto opened =
      Require(BlockedVolume::Open(this->Path, this->Files, std::make_shared<BlockCache>(1 << 20)));
    QueryStatistics statistics;
    bool equal = true;
    for (const BlockReference& reference : Require(opened->ListBlocks(step, statistics)))
    {
      const auto block = Require(opened->ReadBlock(reference, step, 0, 0, statistics));
      VisitVertices(block->View.Box,
        [&](const Index3& vertex)
        { equal = equal && *block->View.At<std::uint8_t>(vertex) == volume.At(vertex); });
    }
    return equal;
  }

  /// The names of all that is beside and below the volume.
  std::size_t CountGenerations()
  {
    return this->Files.List(HidePath(this->Path + ".stores"))->size();
  }

  FileSystem& Files = GetLocalFileSystem();
  std::string Folder;
  std::string Path;
};

/// Runs a body in a child; its result is the child's exit code.
pid_t Start(const std::function<int()>& body)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    ::_exit(body());
  }
  EXPECT_GT(child, 0) << "no process could be started";
  return child;
}

int Wait(pid_t child)
{
  int state = 0;
  EXPECT_EQ(::waitpid(child, &state, 0), child);
  return WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
}

} // namespace

TEST_F(BlockedVolumeCrash, LeavesAWholeVolumeWheneverItIsKilled)
{
  const Index3 size = { 98, 90, 82 };
  const auto even = MakeVolume<std::uint8_t>(size, 1);
  const auto odd = MakeVolume<std::uint8_t>(size, 2);
  ASSERT_TRUE(this->Write(odd).IsOk());
  const auto begin = Clock::now();
  ASSERT_EQ(Wait(Start([&] { return this->Write(even).IsOk() ? 0 : 1; })), 0);
  const auto whole = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin);
  constexpr SegmentCodec codecs[] = { SegmentCodec::None, SegmentCodec::Lz4, SegmentCodec::Zstd };
  std::mt19937 random(3);
  bool isEven = true;
  int killed = 0;
  const int turns = LongTests ? 50 : 20;
  for (int turn = 0; turn < turns; ++turn)
  {
    const auto& next = isEven ? odd : even;
    const pid_t child =
      Start([&] { return this->Write(next, {}, codecs[turn % 3]).IsOk() ? 0 : 1; });
    ::usleep(static_cast<unsigned>(random() % static_cast<unsigned>(whole.count())));
    ASSERT_GT(child, 0);
    ::kill(child, SIGKILL);
    const int outcome = Wait(child);
    ASSERT_TRUE(outcome == 0 || outcome == -SIGKILL);
    killed += outcome == -SIGKILL ? 1 : 0;
    const bool isReplaced = this->Holds(next);
    ASSERT_TRUE(isReplaced || this->Holds(isEven ? even : odd)) << "after turn " << turn;
    ASSERT_TRUE(isReplaced || outcome != 0);
    isEven = isReplaced != isEven;
  }
  EXPECT_GT(killed, turns / 5);
  // The next run removes whatever the killed ones left.
  ASSERT_TRUE(this->Write(even).IsOk());
  EXPECT_TRUE(this->Holds(even));
  EXPECT_EQ(this->CountGenerations(), 1u);
  EXPECT_EQ(*this->Files.List(this->Folder),
    (std::vector<std::string>{ ".volume.bvol.stores", "volume.bvol" }));
}

TEST_F(BlockedVolumeCrash, LeavesAllTimeStepsWheneverAnAppendIsKilled)
{
  const Index3 size = { 70, 60, 50 };
  const auto first = MakeVolume<std::uint8_t>(size, 1);
  const auto later = MakeVolume<std::uint8_t>(size, 2);
  ASSERT_TRUE(this->Append(first, 0).IsOk());
  const auto begin = Clock::now();
  ASSERT_EQ(Wait(Start([&] { return this->Append(later, 1).IsOk() ? 0 : 1; })), 0);
  const auto whole = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin);
  std::mt19937 random(5);
  std::size_t steps = 2;
  int killed = 0;
  const int turns = LongTests ? 30 : 12;
  for (int turn = 0; turn < turns; ++turn)
  {
    const pid_t child =
      Start([&] { return this->Append(later, static_cast<double>(steps)).IsOk() ? 0 : 1; });
    ASSERT_GT(child, 0);
    ::usleep(static_cast<unsigned>(random() % static_cast<unsigned>(whole.count())));
    ::kill(child, SIGKILL);
    const int outcome = Wait(child);
    ASSERT_TRUE(outcome == 0 || outcome == -SIGKILL);
    killed += outcome == -SIGKILL ? 1 : 0;
    const auto header = Require(BlockedVolumeHeader::Read(this->Files, this->Path));
    ASSERT_TRUE(header.TimeSteps.size() == steps || header.TimeSteps.size() == steps + 1);
    ASSERT_TRUE(outcome != 0 || header.TimeSteps.size() == steps + 1);
    steps = header.TimeSteps.size();
    ASSERT_TRUE(this->Holds(first, 0)) << "after turn " << turn;
    ASSERT_TRUE(this->Holds(later, steps - 1)) << "after turn " << turn;
  }
  EXPECT_GT(killed, turns / 6);
  ASSERT_TRUE(this->Append(later, static_cast<double>(steps)).IsOk());
  EXPECT_EQ(this->CountGenerations(), steps + 1);
  for (std::size_t step = 0; step <= steps; ++step)
  {
    EXPECT_TRUE(this->Holds(step == 0 ? first : later, step));
  }
}

TEST_F(BlockedVolumeCrash, LeavesTheOldVolumeWhenFilesMayNotGrow)
{
  const Index3 size = { 60, 50, 40 };
  const auto before = MakeVolume<std::uint8_t>(size, 1);
  const auto after = MakeVolume<std::uint8_t>(size, 2);
  ASSERT_TRUE(this->Write(before).IsOk());
  for (const rlim_t limit : { 0u, 1u, 1000u, 4096u, 20000u, 50000u, 100000u })
  {
    const int outcome = Wait(Start(
      [&]
      {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit bytes = { limit, limit };
        ::setrlimit(RLIMIT_FSIZE, &bytes);
        const Status status = this->Write(after);
        return status.IsOk() ? 0 : status.GetMessage().find("File too large") == std::string::npos;
      }));
    EXPECT_EQ(outcome, 0) << limit;
    EXPECT_EQ(this->CountGenerations(), 1u);
    EXPECT_EQ(this->Files.List(this->Folder)->size(), 2u);
    if (!this->Holds(before))
    {
      EXPECT_GT(limit, 20000u);
      EXPECT_TRUE(this->Holds(after));
    }
  }
}

TEST_F(BlockedVolumeCrash, LeavesRoomForTheNextRunAfterAKilledOne)
{
  const Index3 size = { 60, 50, 40 };
  const auto before = MakeVolume<std::uint8_t>(size, 1);
  const auto after = MakeVolume<std::uint8_t>(size, 2);
  ASSERT_TRUE(this->Write(before).IsOk());
  // Killed with its blocks written.
  const auto killItself = [](double share) { return share < 0.9 || ::raise(SIGKILL) == 0; };
  ASSERT_EQ(Wait(Start([&] { return this->Write(after, killItself).IsOk() ? 0 : 1; })), -SIGKILL);
  EXPECT_EQ(this->CountGenerations(), 2u);
  EXPECT_TRUE(this->Holds(before));
  std::size_t atBegin = 0;
  const auto look = [&](double)
  {
    atBegin = std::max(atBegin, this->CountGenerations());
    return true;
  };
  ASSERT_TRUE(this->Write(after, look).IsOk());
  EXPECT_EQ(atBegin, 2u) << "the killed run's folder stood beside the old one and the new one";
  EXPECT_EQ(this->CountGenerations(), 1u);
  EXPECT_TRUE(this->Holds(after));
}

TEST_F(BlockedVolumeCrash, IsCleanedBehindWithoutAnotherRun)
{
  const Index3 size = { 60, 50, 40 };
  const auto before = MakeVolume<std::uint8_t>(size, 1);
  const auto after = MakeVolume<std::uint8_t>(size, 2);
  const auto killItself = [](double share) { return share < 0.9 || ::raise(SIGKILL) == 0; };
  const auto writeAndClean = [&]
  {
    EXPECT_EQ(Wait(Start([&] { return this->Write(after, killItself).IsOk() ? 0 : 1; })), -SIGKILL);
    GenerationFolder::RemoveUnfinished(this->Files, this->Path);
  };
  writeAndClean();
  EXPECT_EQ(this->Files.List(this->Folder)->size(), 0u);
  ASSERT_TRUE(this->Write(before).IsOk());
  writeAndClean();
  EXPECT_EQ(this->CountGenerations(), 1u);
  EXPECT_TRUE(this->Holds(before));
  // While somebody writes, nothing is removed.
  const auto clean = [&](double)
  {
    GenerationFolder::RemoveUnfinished(this->Files, this->Path);
    return true;
  };
  ASSERT_TRUE(this->Write(after, clean).IsOk());
  EXPECT_TRUE(this->Holds(after));
}

TEST_F(BlockedVolumeCrash, HasMoreStoresThanThereAreDescriptors)
{
  const Index3 size = { 150, 130, 110 };
  const auto volume = MakeVolume<std::uint8_t>(size, 1);
  const int outcome = Wait(Start(
    [&]
    {
      const rlimit few = { 40, 40 };
      ::setrlimit(RLIMIT_NOFILE, &few);
      BlockedVolumeSettings settings = MakeSettings(16, 300);
      settings.Threads = 3;
      if (const Status status = this->Write(volume, settings); !status.IsOk())
      {
        std::fprintf(stderr, "%s\n", status.GetMessage().c_str());
        return 1;
      }
      const auto found = VerifyBlockedVolume(this->Path, this->Files, 3);
      return found.IsOk() && found->Faults.empty() && this->Holds(volume) ? 0 : 2;
    }));
  EXPECT_EQ(outcome, 0);
}

TEST_F(BlockedVolumeCrash, RefusesASecondWriterUntilTheFirstOneIsGone)
{
  const Index3 size = { 60, 50, 40 };
  const auto before = MakeVolume<std::uint8_t>(size, 1);
  const auto after = MakeVolume<std::uint8_t>(size, 2);
  ASSERT_TRUE(this->Write(before).IsOk());
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t first = Start(
    [&]
    {
      const auto stop = [&](double share)
      {
        if (share > 0.5)
        {
          static_cast<void>(::write(ready[1], "", 1));
          ::pause();
        }
        return true;
      };
      return this->Write(after, stop).IsOk() ? 0 : 1;
    });
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  const Status refused = this->Write(after);
  ExpectError(refused, StatusCode::IoError, "volume.bvol");
  ExpectMessage(refused, "another program is writing");
  EXPECT_EQ(this->CountGenerations(), 2u) << "the second writer touched the first one's folder";
  EXPECT_TRUE(this->Holds(before));
  ::kill(first, SIGKILL);
  EXPECT_EQ(Wait(first), -SIGKILL);
  EXPECT_TRUE(this->Write(after).IsOk());
  EXPECT_EQ(this->CountGenerations(), 1u);
  EXPECT_TRUE(this->Holds(after));
  ::close(ready[0]);
  ::close(ready[1]);
}

namespace
{

/// The peak of this process's resident memory, as the system has it.
std::uint64_t FindPeakBytes()
{
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
  {
    if (line.compare(0, 6, "VmHWM:") == 0)
    {
      return std::stoull(line.substr(6)) * 1024;
    }
  }
  return 0;
}

} // namespace

TEST_F(BlockedVolumeCrash, KeepsItsMemoryWithinTheLimit)
{
  // 64 MB, of which no slice is like another.
  const Index3 size = { 400, 410, 390 };
  const std::string samples = this->Folder + "/samples.raw";
  {
    std::vector<std::uint8_t> slice(static_cast<std::size_t>(size[0] * size[1]));
    auto file = Require(this->Files.CreateForWriting(samples));
    for (std::int64_t k = 0; k < size[2]; ++k)
    {
      for (std::size_t at = 0; at < slice.size(); ++at)
      {
        slice[at] = static_cast<std::uint8_t>((at / 64 + static_cast<std::size_t>(k)) / 8);
      }
      ASSERT_TRUE(file->Append(slice.data(), slice.size()).IsOk());
    }
  }
  RawVolume raw;
  raw.Grid = MakeGeometry(size);
  raw.Paths = { samples };
  for (const std::uint64_t limit : { std::uint64_t{ 16 } << 20, std::uint64_t{ 48 } << 20 })
  {
    for (const int threads : { 1, 2 })
    {
      const int outcome = Wait(Start(
        [&]
        {
          const std::uint64_t before = FindPeakBytes();
          BlockedVolumeSettings settings = MakeSettings(32, 3);
          settings.MemoryLimit = limit;
          settings.Threads = threads;
          const auto source = raw.Open(this->Files);
          SerialCommunicator serial;
          const auto written = BlockedVolumeWriter(serial).Write(
            this->Path, raw.Grid, { { "density", raw.Type } }, **source, settings);
          const std::uint64_t used = FindPeakBytes() - before;
          return written.IsOk() ? (used <= limit ? 0 : 2) : 1;
        }));
      EXPECT_EQ(outcome, 0);
    }
  }
}
