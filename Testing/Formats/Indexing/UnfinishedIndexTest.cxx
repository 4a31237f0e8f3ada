// SPDX-License-Identifier: BSD-3-Clause
// An index whose writing was stopped, failed or was killed, and the next try, which goes on there.
#include "Fixtures/LongTests.h"
#include "Fixtures/SampleFiles.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "Storage/Writing/GenerationFolder.h"
#include "Storage/Writing/WriteJournal.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

const Index3 UnfinishedSize = { 40, 36, 138 };
const std::string IndexName = "scan.bvol";

/// A disk whose folders can be locked, as those of a real one.
class LockingDisk : public MemoryDisk
{
public:
  Result<std::unique_ptr<PathLock>> LockFolder(const std::string& path) override
  {
    struct Lock : public PathLock
    {
      bool IsExclusive() const override { return true; }
    };
    ISOSURFACE_RETURN_IF_ERROR(this->MakeDirectories(path));
    return std::unique_ptr<PathLock>(new Lock);
  }
};

std::string GetSource(const std::string& folder, std::size_t step)
{
  return folder + "/scan" + std::to_string(step) + ".mhd";
}

/// The header of a source and its samples.
MemoryDisk::Bytes MakeHeader(std::size_t step)
{
  return MakeBytes("ObjectType = Image\nNDims = 3\nDimSize = " + std::to_string(UnfinishedSize[0]) +
    " " + std::to_string(UnfinishedSize[1]) + " " + std::to_string(UnfinishedSize[2]) +
    "\nElementType = MET_SHORT\nElementDataFile = scan" + std::to_string(step) + ".mhd.raw\n");
}

MemoryDisk::Bytes MakeSamples(std::uint32_t seed)
{
  return MakeBytes(MakeVolume<std::int16_t>(UnfinishedSize, seed));
}

/// Indexes a series with a checkpoint after each round, of which there are many: in place, or as the
/// indices of streams, by copies.
Status WriteIndex(Communicator& ranks, FileSystem& files, const std::string& folder,
  std::size_t steps, bool isCopied, const Progress& progress)
{
  BlockedVolumeWriter writer(ranks, files);
  const std::string path = folder + "/" + IndexName;
  for (std::size_t step = 0; step < steps; ++step)
  {
    const std::string source = GetSource(folder, step);
    auto volume = OpenForeignVolume(files, source);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(volume.GetStatus()));
    const auto record = DescribeSource(
      files, OpenForeignVolume, path, source, SourceRecord{}, volume->Grid, volume->Arrays);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(record.GetStatus()));
    BlockedVolumeSettings settings;
    settings.BlockSize = 16;
    settings.Distribution = DistributionMethod::Slab;
    (isCopied ? settings.CopyOf : settings.InPlace) = *record;
    settings.JournalSeconds = 0;
    settings.MemoryLimit = 2400000;
    settings.Threads = 1;
    settings.Append = step > 0;
    settings.Time = static_cast<double>(step);
    settings.Publish = step + 1 == steps;
    ISOSURFACE_RETURN_IF_ERROR(
      writer.Write(path, volume->Grid, volume->Arrays, *volume->Source, settings, progress)
        .GetStatus());
  }
  return Status::Ok();
}

/// The same by several ranks, each of which calls `progress`.
Status WriteByRanks(FileSystem& files, const std::string& folder, int ranks, std::size_t steps,
  const std::function<bool(int rank)>& goesOn, bool isCopied = false)
{
  return ThreadCommunicator::Collect(ranks,
    [&](Communicator& communicator)
    {
      return WriteIndex(communicator, files, folder, steps, isCopied,
        [&](double) { return goesOn(communicator.GetRank()); });
    })[0];
}

bool GoOn(int)
{
  return true;
}

/// Stops the first rank at a call of its progress.
std::function<bool(int)> StopAtCall(int call)
{
  return [call, calls = std::make_shared<int>(0)](int rank)
  { return rank != 0 || (*calls)++ != call; };
}

void SetSources(MemoryDisk& disk, std::size_t steps)
{
  for (std::size_t step = 0; step < steps; ++step)
  {
    disk.SetFile(GetSource("/data", step), MakeHeader(step));
    disk.SetFile(
      GetSource("/data", step) + ".raw", MakeSamples(static_cast<std::uint32_t>(step + 1)));
  }
}

/// What a write at once leaves.
std::map<std::string, MemoryDisk::Bytes> WriteAtOnce(
  int ranks, std::size_t steps, bool isCopied = false)
{
  LockingDisk disk;
  SetSources(disk, steps);
  const Status status = WriteByRanks(disk, "/data", ranks, steps, GoOn, isCopied);
  EXPECT_TRUE(status.IsOk()) << status.GetMessage();
  return disk.Copy();
}

/// Goes on with what is on the disk. Returns the share of the sources that is read for it.
double Finish(LockingDisk& disk, int ranks, std::size_t steps, bool isCopied = false)
{
  const std::uint64_t before = disk.GetBytesRead(".raw");
  const Status status = WriteByRanks(disk, "/data", ranks, steps, GoOn, isCopied);
  EXPECT_TRUE(status.IsOk()) << status.GetMessage();
  return static_cast<double>(disk.GetBytesRead(".raw") - before) /
    static_cast<double>(steps * disk.GetFile(GetSource("/data", 0) + ".raw").size());
}

/// Whether the samples are copied.
class UnfinishedIndexTest : public testing::TestWithParam<bool>
{
};

} // namespace

TEST_P(UnfinishedIndexTest, GoesOnWhereItWasStoppedWithAnyNumberOfRanks)
{
  const bool isCopied = this->GetParam();
  const std::vector<std::pair<int, int>> pairs = { { 1, 1 }, { 1, 3 }, { 3, 1 }, { 4, 7 } };
  for (const auto& [first, later] : pairs)
  {
    LockingDisk atOnce;
    SetSources(atOnce, 1);
    const double whole = Finish(atOnce, first, 1, isCopied);
    double last = 0;
    for (int call = 0;; call += LongTests ? 1 : 4)
    {
      SCOPED_TRACE(std::to_string(first) + " ranks, stopped at call " + std::to_string(call));
      LockingDisk disk;
      SetSources(disk, 1);
      const Status stopped = WriteByRanks(disk, "/data", first, 1, StopAtCall(call), isCopied);
      if (stopped.IsOk())
      {
        EXPECT_GT(call, 6) << "there should have been more rounds";
        break;
      }
      ASSERT_EQ(stopped.GetCode(), StatusCode::Aborted) << stopped.GetMessage();
      EXPECT_FALSE(disk.Exists("/data/" + IndexName));
      last = Finish(disk, later, 1, isCopied);
      EXPECT_TRUE(first != later || last < whole);
      ASSERT_EQ(disk.Copy(), atOnce.Copy());
    }
    EXPECT_LT(last, 0.1 * whole) << "at the end nearly nothing was left to read";
  }
}

TEST_P(UnfinishedIndexTest, ReadsTimeStepsThatAreFinishedNoMore)
{
  const bool isCopied = this->GetParam();
  LockingDisk disk;
  SetSources(disk, 3);
  int callsOfAStep = 0;
  {
    LockingDisk one;
    SetSources(one, 1);
    const auto count = [&](int) { return ++callsOfAStep > 0; };
    EXPECT_TRUE(WriteByRanks(one, "/data", 1, 1, count, isCopied).IsOk());
  }
  EXPECT_FALSE(
    WriteByRanks(disk, "/data", 1, 3, StopAtCall(2 * callsOfAStep + 1), isCopied).IsOk());
  EXPECT_LT(Finish(disk, 1, 3, isCopied), 0.4);
  EXPECT_EQ(disk.Copy(), WriteAtOnce(1, 3, isCopied));
}

INSTANTIATE_TEST_SUITE_P(InPlaceAndCopied, UnfinishedIndexTest, testing::Bool());

TEST(UnfinishedIndex, IsThatOfAWriteAtOnceAfterTheDiskFailedAtAnyOperation)
{
  for (const int ranks : { 1, 3 })
  {
    const auto expected = WriteAtOnce(ranks, 2);
    for (std::uint64_t write = 0;; write += LongTests ? 1 : 97)
    {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, failed at write " + std::to_string(write));
      LockingDisk disk;
      SetSources(disk, 2);
      disk.FailFromWrite(write);
      const Status failed = WriteByRanks(disk, "/data", ranks, 2, GoOn);
      if (failed.IsOk())
      {
        EXPECT_GT(write, 100u);
        break;
      }
      disk.FailFromWrite(MemoryDisk::Never);
      Finish(disk, ranks, 2);
      ASSERT_EQ(disk.Copy(), expected);
    }
  }
}

TEST(UnfinishedIndex, IsNotKeptWhereFoldersCannotBeLocked)
{
  for (const bool canLock : { true, false })
  {
    LockingDisk locking;
    MemoryDisk plain;
    MemoryDisk& disk = canLock ? locking : plain;
    SetSources(disk, 1);
    const std::size_t sources = disk.GetFiles().size();
    EXPECT_EQ(WriteByRanks(disk, "/data", 1, 1, StopAtCall(6)).GetCode(), StatusCode::Aborted);
    EXPECT_EQ(disk.GetFiles().size() > sources, canLock);
  }
}

TEST(UnfinishedIndex, IsWrittenAnewIfTheSourceHasChangedOrTheJournalIsDamaged)
{
  LockingDisk stopped;
  SetSources(stopped, 1);
  EXPECT_FALSE(WriteByRanks(stopped, "/data", 2, 1, StopAtCall(4)).IsOk());
  const auto left = stopped.Copy();
  const auto makeDisk = [&]
  {
    auto disk = std::make_unique<LockingDisk>();
    for (const auto& [path, bytes] : left)
    {
      EXPECT_TRUE(disk->MakeDirectories(path.substr(0, path.rfind('/'))).IsOk());
      disk->SetFile(path, bytes);
    }
    return disk;
  };
  EXPECT_LT(Finish(*makeDisk(), 2, 1), 1);

  const auto changed = makeDisk();
  LockingDisk other;
  for (LockingDisk* disk : { changed.get(), &other })
  {
    disk->SetFile(GetSource("/data", 0), MakeHeader(0));
    disk->SetFile(GetSource("/data", 0) + ".raw", MakeSamples(9));
    disk->SetModified(GetSource("/data", 0) + ".raw", 2);
    EXPECT_GE(Finish(*disk, 2, 1), 1);
  }
  EXPECT_EQ(changed->Copy(), other.Copy());

  const auto expected = WriteAtOnce(2, 1);
  int damaged = 0;
  for (const auto& [path, bytes] : left)
  {
    const bool isJournal = path.find("journal") != std::string::npos ||
      path.find("checkpoint") != std::string::npos || path.find("entries") != std::string::npos;
    for (std::size_t at = 0; isJournal && at < bytes.size(); at += LongTests ? 97 : 9001)
    {
      SCOPED_TRACE(path + ", byte " + std::to_string(at));
      const auto flipped = makeDisk();
      flipped->GetFile(path)[at] ^= 4;
      Finish(*flipped, 2, 1);
      ASSERT_EQ(flipped->Copy(), expected);
      const auto cut = makeDisk();
      cut->GetFile(path).resize(at);
      Finish(*cut, 2, 1);
      ASSERT_EQ(cut->Copy(), expected);
      ++damaged;
    }
  }
  EXPECT_GT(damaged, 5);
}

TEST(UnfinishedIndex, IsWrittenAnewIfAnyByteOfItsBlocksOrOfTheSamplesOfCoarserLevelsIsDamaged)
{
  for (const bool isCopied : { false, true })
  {
    const auto expected = WriteAtOnce(3, 1, isCopied);
    for (const std::string name : { "blocks", "overview-samples" })
    {
      for (const double place : { 0.0, 0.4, 1.0 })
      {
        SCOPED_TRACE(name + (isCopied ? " of a copy, at " : ", at ") + std::to_string(place));
        LockingDisk disk;
        SetSources(disk, 1);
        EXPECT_FALSE(WriteByRanks(disk, "/data", 3, 1, StopAtCall(4), isCopied).IsOk());
        int damaged = 0;
        for (const auto& [path, bytes] : disk.GetFiles())
        {
          if (path.find("/" + name) != std::string::npos && !bytes->empty())
          {
            (*bytes)[static_cast<std::size_t>(place * static_cast<double>(bytes->size() - 1))] ^= 1;
            ++damaged;
          }
        }
        ASSERT_GT(damaged, 0);
        EXPECT_GE(Finish(disk, 3, 1, isCopied), 1);
        EXPECT_EQ(disk.Copy(), expected);
      }
    }
  }
}

namespace
{

/// The files of the index in a folder on the local disk, but for its header, which has the time when
/// the source was modified.
std::map<std::string, std::string> ReadStores(const std::string& folder)
{
  const std::filesystem::path stores = folder + "/" + HidePath(IndexName + ".stores");
  std::map<std::string, std::string> files;
  if (!std::filesystem::exists(stores)) // nothing was written yet
  {
    return files;
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(stores))
  {
    if (entry.is_regular_file())
    {
      std::ifstream file(entry.path(), std::ios::binary);
      files[entry.path().lexically_relative(stores).string()].assign(
        std::istreambuf_iterator<char>(file), {});
    }
  }
  return files;
}

void SetLocalSource(const std::string& folder)
{
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto write = [](const std::string& path, const MemoryDisk::Bytes& bytes)
  {
    std::ofstream(path, std::ios::binary)
      .write(
        reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  write(GetSource(folder, 0), MakeHeader(0));
  write(GetSource(folder, 0) + ".raw", MakeSamples(1));
}

/// Indexes by a process of its own that is killed after so many microseconds. Whether it has ended.
bool WriteAndKill(const std::string& folder, int ranks, useconds_t after)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    ::_exit(WriteByRanks(GetLocalFileSystem(), folder, ranks, 1, GoOn).IsOk() ? 0 : 1);
  }
  EXPECT_GT(child, 0) << "no process could be started";
  ::usleep(after);
  ::kill(child, SIGKILL);
  int state = 0;
  EXPECT_EQ(::waitpid(child, &state, 0), child);
  EXPECT_TRUE(!WIFEXITED(state) || WEXITSTATUS(state) == 0);
  return WIFEXITED(state);
}

/// Has what the next program would remove removed now: the journal and what it names stay.
void RemoveUnfinished(const std::string& folder)
{
  const std::string path = folder + "/" + IndexName;
  const auto before = ReadStores(folder);
  GenerationFolder::RemoveUnfinished(GetLocalFileSystem(), path);
  const auto found = before.find("journal");
  if (found == before.end())
  {
    // A program that is killed as it ends has finished the index.
    EXPECT_EQ(std::filesystem::exists(HidePath(path + ".stores")), std::filesystem::exists(path));
    return;
  }
  // The index that a program has finished is replaced by the next program's.
  BlockedVolumeHeader named;
  if (std::filesystem::exists(path))
  {
    named = Require(BlockedVolumeHeader::Read(GetLocalFileSystem(), path));
  }
  named.TimeSteps.emplace_back().Folder = Require(WriteJournal::Parse(found->second, path)).Folder;
  auto kept = before;
  for (auto file = kept.begin(); file != kept.end();)
  {
    const bool isNamed =
      file->first == "journal" || named.HasFolder(file->first.substr(0, file->first.find('/')));
    file = isNamed ? std::next(file) : kept.erase(file);
  }
  EXPECT_EQ(ReadStores(folder), kept);
}

} // namespace

TEST(UnfinishedIndex, IsThatOfAWriteAtOnceHoweverOftenTheProgramIsKilled)
{
  const std::string folder =
    ::testing::TempDir() + "isosurface-unfinished-" + std::to_string(::getpid());
  const std::string whole = folder + "/whole";
  std::mt19937 random(4);
  const int wanted = LongTests ? 100 : 10;
  int killed = 0;
  while (killed < wanted)
  {
    SetLocalSource(folder);
    // Longer and longer, so that it ends on a busy machine, too.
    for (useconds_t longest = 100000;
         !WriteAndKill(folder, 1 + static_cast<int>(random() % 4), random() % longest);
         longest += longest / 4)
    {
      ++killed;
      if (killed % 2 == 0)
      {
        RemoveUnfinished(folder);
      }
    }
    RemoveUnfinished(folder);
    const auto header =
      Require(BlockedVolumeHeader::Read(GetLocalFileSystem(), folder + "/" + IndexName));
    SetLocalSource(whole);
    ASSERT_TRUE(
      WriteByRanks(GetLocalFileSystem(), whole, static_cast<int>(header.NumberOfStores), 1, GoOn)
        .IsOk());
    auto files = ReadStores(folder);
    auto expected = ReadStores(whole);
    ASSERT_EQ(files.size(), expected.size());
    // Folders are numbered; those of killed programs that wrote no checkpoint are counted.
    ASSERT_TRUE(std::equal(files.begin(), files.end(), expected.begin(),
      [](const auto& mine, const auto& other)
      {
        return mine.first.substr(mine.first.find('/')) ==
          other.first.substr(other.first.find('/')) &&
          mine.second == other.second;
      }))
      << "after " << killed << " kills";
  }
  std::filesystem::remove_all(folder);
}
