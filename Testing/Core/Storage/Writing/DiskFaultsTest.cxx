// SPDX-License-Identifier: BSD-3-Clause
// A fault of the disk at every single operation of writing a volume, appending a time step, writing
// an edge-index file, and asking for a surface: what was there before stays whole, all ranks get
// the error, the next run succeeds.
#include "DiskFaults.h"
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/TestBlockSource.h"
#include "Fixtures/VolumeOnDisk.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <cerrno>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

using Kind = DiskFaults::Kind;
using Samples = SampleVolume<std::uint8_t>;

/// A kind of fault, and what has to come of it.
struct Fault
{
  Kind What;
  int Error = 0;
  bool IsFatal = true; ///< whether the operation fails, rather than to go on
  int Ranks = 1;
};

const std::vector<Fault> Disturbances = {
  { Kind::Fail, EIO, true, 1 },
  { Kind::Fail, EIO, true, 2 },
  { Kind::FailFromNow, EROFS, true, 1 },
  { Kind::FailFromNow, ENOSPC, true, 2 },
  { Kind::FailFromNow, EMFILE, true, 1 },
  { Kind::Interrupt, EINTR, false, 2 },
  { Kind::Short, 0, false, 2 },
  { Kind::Stale, ESTALE, false, 1 },
};
const std::vector<Fault> Kills = { { Kind::Kill }, { Kind::Tear } };

const Index3 Size = { 34, 18, 17 };
constexpr double Isovalue = 20;

class DiskFaultsAtEveryOperation : public testing::Test
{
protected:
  void SetUp() override
  {
    // In memory, where there is such a folder: thousands of volumes are written and removed.
    const std::string place = this->Files.Exists("/dev/shm") ? "/dev/shm/" : testing::TempDir();
    this->Folder = place + "isosurface-faults-" + std::to_string(::getpid());
    ASSERT_TRUE(this->Files.RemoveAll(this->Folder).IsOk());
    ASSERT_TRUE(this->Files.MakeDirectories(this->Folder).IsOk());
    DiskFaults::Watch(this->Folder + "/");
    this->Volume = this->Folder + "/volume.bvol";
    this->Surface = this->Folder + "/surface.eix";
  }
  void TearDown() override
  {
    RecordProperty("faults", std::to_string(this->Faults));
    DiskFaults::Disarm();
    DiskFaults::Watch("");
    ASSERT_TRUE(this->Files.RemoveAll(this->Folder).IsOk());
  }

  /// What each of the ranks gets.
  static std::vector<Status> OnRanks(
    int ranks, const std::function<Status(Communicator& communicator)>& body)
  {
    if (ranks == 1)
    {
      SerialCommunicator alone; // in this thread, which may be that of a forked process
      return { body(alone) };
    }
    return ThreadCommunicator::Collect(ranks, body);
  }

  std::vector<Status> Write(const Samples& samples, int ranks, std::optional<double> time = {})
  {
    return OnRanks(ranks,
      [&](Communicator& communicator)
      {
        const VertexBox box = SlabOfEach(communicator.GetRank(), ranks, Size);
        const PieceOfVolume<std::uint8_t> part(samples, box);
        BlockedVolumeSettings settings = MakeSettings(16, 2);
        settings.Threads = 1;
        settings.Time = time;
        settings.Append = time.has_value();
        return BlockedVolumeWriter(communicator, this->Files)
          .Write(this->Volume, MakeGeometry(Size), { { "density", ValueType::UInt8 } },
            VolumePiece{ box, { part.View } }, settings)
          .GetStatus();
      });
  }

  std::vector<Status> WriteSurface(const Samples& samples, int ranks)
  {
    return OnRanks(ranks,
      [&](Communicator& communicator)
      {
        TestBlockSource<std::uint8_t> source(samples, 16);
        std::vector<std::int64_t> numbers;
        if (communicator.GetRank() == 0)
        {
          for (std::size_t block = 0; block < source.GetNumberOfBlocks(); ++block)
          {
            numbers.push_back(static_cast<std::int64_t>(block));
          }
        }
        EdgeIndexHeader header;
        header.Geometry = samples.Geometry;
        header.Type = ValueType::UInt8;
        header.Isovalues = { Isovalue };
        EdgeIndexWriteJob job(
          communicator, this->Files, this->Surface, header, source, numbers, {});
        return job.Run().GetStatus();
      });
  }

  /// The number of triangles of the isosurface of a time step.
  Result<std::size_t> CountTriangles(std::size_t step = 0)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto volume,
      BlockedVolume::Open(
        this->Volume, this->Files, std::make_shared<BlockCache>(std::uint64_t{ 1 } << 24)));
    QueryStatistics statistics;
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto active, FindActiveBlocks(*volume, { { step, 0, { Isovalue } } }, statistics));
    ISOSURFACE_RETURN_IF_ERROR(volume->GetSpectrum(step, 0).GetStatus());
    StoredBlockSource source(*volume, step, 0, 0, std::move(active));
    ContourRequest request;
    request.Isovalues = { Isovalue };
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto surface, ExtractSurface(volume->GetHeader().Grid, source, request, 1));
    return surface.NumberOfTriangles;
  }

  std::string Verify()
  {
    const auto found = VerifyBlockedVolume(this->Volume, this->Files, 1);
    return found.IsOk() && found->Faults.empty() ? "" : found->Faults.front().GetMessage();
  }

  std::size_t CountSteps()
  {
    const auto header = BlockedVolumeHeader::Read(this->Files, this->Volume);
    return header.IsOk() ? header->TimeSteps.size() : 0;
  }

  /// All ranks have an error that names a file here and the system's reason, or none has.
  void ExpectAgreed(const std::vector<Status>& outcomes, const Fault& fault)
  {
    for (const Status& status : outcomes)
    {
      EXPECT_EQ(status.IsOk(), outcomes.front().IsOk()) << status.GetMessage();
      if (!status.IsOk())
      {
        ExpectMessage(status, this->Folder);
        ExpectMessage(status, std::strerror(fault.Error));
      }
    }
  }

  /**
   * Does something with a fault at operation 0, 1, ... until there is none left, and each time
   * looks at what is there then. Each kind of fault is at every fifth operation, the next kind at the
   * one after it, so that all operations fail in one of the five fatal ways; in long tests, in every way.
   */
  void ForEachOperation(const std::vector<Fault>& faults,
    const std::function<std::vector<Status>(int ranks)>& act,
    const std::function<void(bool isDone)>& look)
  {
    for (std::size_t kind = 0; kind < faults.size(); ++kind)
    {
      const Fault& fault = faults[kind];
      std::uint64_t operation = LongTests ? 0 : kind % 5;
      for (bool isLast = false; !isLast; operation += LongTests ? 1 : 5)
      {
        ASSERT_LT(operation, 5000u);
        DiskFaults::Arm(fault.What, fault.Error, operation);
        const std::vector<Status> outcomes = act(fault.Ranks);
        isLast = DiskFaults::GetOperations() <= operation;
        this->Faults += isLast ? 0 : 1;
        DiskFaults::Disarm();
        SCOPED_TRACE("operation " + std::to_string(operation) + " with " +
          std::strerror(fault.Error) + " on " + std::to_string(fault.Ranks) + " ranks");
        this->ExpectAgreed(outcomes, fault);
        if (!fault.IsFatal || isLast)
        {
          EXPECT_TRUE(outcomes.front().IsOk()) << outcomes.front().GetMessage();
        }
        look(outcomes.front().IsOk());
        if (HasFailure())
        {
          return;
        }
      }
      EXPECT_GT(operation, 5u) << "the test watches nothing";
    }
  }

  /// The same in a process that dies there: killed before, or torn within, every second operation.
  void ForEachDeath(
    const std::function<std::vector<Status>()>& act, const std::function<void(bool isDone)>& look)
  {
    for (std::size_t kind = 0; kind < Kills.size(); ++kind)
    {
      bool isDone = false;
      for (std::uint64_t operation = LongTests ? 0 : kind; !isDone; operation += LongTests ? 1 : 2)
      {
        ASSERT_LT(operation, 5000u);
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0)
        {
          DiskFaults::Arm(Kills[kind].What, 0, operation);
          ::_exit(act().front().IsOk() ? 0 : 1);
        }
        int state = 0;
        ASSERT_EQ(::waitpid(child, &state, 0), child);
        ASSERT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) != 1) << state;
        isDone = WEXITSTATUS(state) == 0;
        this->Faults += isDone ? 0 : 1;
        SCOPED_TRACE("dead before operation " + std::to_string(operation));
        look(isDone);
        if (HasFailure())
        {
          return;
        }
      }
    }
  }

  FileSystem& Files = GetLocalFileSystem();
  std::string Folder;
  std::string Volume;
  std::string Surface;
  std::uint64_t Faults = 0; ///< that have happened
  const Samples Old = MakeVolume<std::uint8_t>(Size, 1);
  const Samples New = MakeVolume<std::uint8_t>(Size, 2);
};

/// A volume that is replaced, again and again.
class DiskFaultsOfWriting : public DiskFaultsAtEveryOperation
{
protected:
  void SetUp() override
  {
    DiskFaultsAtEveryOperation::SetUp();
    ASSERT_TRUE(this->Write(this->New, 1).front().IsOk());
    this->TrianglesOfNew = *this->CountTriangles();
    this->Restore();
    this->TrianglesOfOld = *this->CountTriangles();
    ASSERT_NE(this->TrianglesOfOld, this->TrianglesOfNew);
  }
  void Restore() { ASSERT_TRUE(this->Write(this->Old, 1).front().IsOk()); }

  void Look(bool isDone)
  {
    EXPECT_EQ(this->Verify(), "");
    const auto triangles = Require(this->CountTriangles());
    EXPECT_TRUE(triangles == this->TrianglesOfNew || (!isDone && triangles == this->TrianglesOfOld))
      << "neither the old volume nor the new one";
    this->Restore();
    EXPECT_EQ(*this->CountTriangles(), this->TrianglesOfOld);
    EXPECT_EQ(this->Files.List(HidePath(this->Volume + ".stores"))->size(), 1u)
      << "something is left over";
    EXPECT_EQ(this->Files.List(this->Folder)->size(), 2u) << "something is left over";
  }

  std::size_t TrianglesOfOld = 0;
  std::size_t TrianglesOfNew = 0;
};

} // namespace

TEST_F(DiskFaultsOfWriting, LeaveTheOldVolumeOrTheNewOne)
{
  this->ForEachOperation(
    Disturbances, [&](int ranks) { return this->Write(this->New, ranks); },
    [&](bool isDone) { this->Look(isDone); });
}

TEST_F(DiskFaultsOfWriting, LeaveTheOldVolumeOrTheNewOneWhenTheWriterDies)
{
  this->ForEachDeath(
    [&] { return this->Write(this->New, 1); }, [&](bool isDone) { this->Look(isDone); });
}

TEST_F(DiskFaultsOfWriting, AreNotThatAFileSystemHasNoLocks)
{
  DiskFaults::Arm(Kind::NoLocks, 0, 0);
  EXPECT_TRUE(this->Write(this->New, 2).front().IsOk());
  EXPECT_TRUE(DiskFaults::HasHappened());
  DiskFaults::Disarm();
  this->Look(true);
}

TEST_F(DiskFaultsAtEveryOperation, OfAppendingLeaveAllTimeStepsBefore)
{
  ASSERT_TRUE(this->Write(this->Old, 1, 0.0).front().IsOk());
  const std::size_t triangles = *this->CountTriangles();
  std::size_t steps = 1;
  const auto look = [&](bool isDone)
  {
    const std::size_t now = this->CountSteps();
    EXPECT_TRUE(now == steps + 1 || (!isDone && now == steps)) << now;
    EXPECT_EQ(this->Verify(), "");
    const auto ofFirst = Require(this->CountTriangles());
    EXPECT_EQ(ofFirst, triangles);
    steps = now;
    if (steps > 3)
    {
      // Begin anew, so that checking all of it takes no longer and longer.
      ASSERT_TRUE(this->Files.RemoveAll(this->Volume).IsOk());
      ASSERT_TRUE(this->Files.RemoveAll(HidePath(this->Volume + ".stores")).IsOk());
      ASSERT_TRUE(this->Write(this->Old, 1, 0.0).front().IsOk());
      steps = 1;
    }
  };
  const auto append = [&](int ranks)
  { return this->Write(this->New, ranks, static_cast<double>(steps)); };
  this->ForEachOperation(Disturbances, append, look);
  this->ForEachDeath([&] { return append(1); }, look);
  ASSERT_TRUE(append(2).front().IsOk());
  EXPECT_EQ(this->CountSteps(), steps + 1);
  EXPECT_EQ(this->Files.List(HidePath(this->Volume + ".stores"))->size(), steps + 1);
}

TEST_F(DiskFaultsAtEveryOperation, OfWritingAnEdgeIndexFileLeaveTheOldOneOrTheNewOne)
{
  const auto read = [&]
  {
    const auto file = this->Files.OpenForReading(this->Surface);
    std::vector<std::uint8_t> bytes(file.IsOk() ? (*file)->GetSize() : 0);
    EXPECT_TRUE(file.IsOk() && (*file)->Read(0, bytes.size(), bytes.data()).IsOk());
    return bytes;
  };
  ASSERT_TRUE(this->WriteSurface(this->New, 1).front().IsOk());
  const auto after = read();
  ASSERT_TRUE(this->WriteSurface(this->Old, 1).front().IsOk());
  const auto before = read();
  ASSERT_NE(before, after);
  const auto look = [&](bool isDone)
  {
    const auto now = read();
    EXPECT_TRUE(now == after || (!isDone && now == before));
    EXPECT_TRUE(this->WriteSurface(this->Old, 2).front().IsOk());
    EXPECT_EQ(read(), before);
    EXPECT_EQ(this->Files.List(this->Folder)->size(), 1u) << "something is left over";
  };
  this->ForEachOperation(
    Disturbances, [&](int ranks) { return this->WriteSurface(this->New, ranks); }, look);
  this->ForEachDeath([&] { return this->WriteSurface(this->New, 1); }, look);
}

TEST_F(DiskFaultsAtEveryOperation, OfQueriesAreToldAndPass)
{
  ASSERT_TRUE(this->Write(this->Old, 1).front().IsOk());
  const std::size_t triangles = *this->CountTriangles();
  std::size_t found = 0;
  this->ForEachOperation(
    Disturbances,
    [&](int)
    {
      const auto count = this->CountTriangles();
      found = count.IsOk() ? *count : 0;
      return std::vector<Status>{ count.GetStatus() };
    },
    [&](bool isDone)
    {
      EXPECT_TRUE(!isDone || found == triangles);
      const auto again = Require(this->CountTriangles());
      EXPECT_EQ(again, triangles);
    });
}

TEST_F(DiskFaultsAtEveryOperation, OfReadingOtherBytesAreFoundAndAreNotKept)
{
  ASSERT_TRUE(this->Write(this->Old, 1).front().IsOk());
  const std::size_t triangles = *this->CountTriangles();
  DiskFaults::Disarm();
  EXPECT_EQ(Require(this->CountTriangles()), triangles);
  const std::uint64_t operations = DiskFaults::GetOperations();
  std::size_t refused = 0;
  for (std::uint64_t operation = 0; operation < operations; ++operation)
  {
    DiskFaults::Arm(Kind::Flip, 0, operation);
    const auto count = this->CountTriangles();
    this->Faults += DiskFaults::HasHappened() ? 1 : 0;
    DiskFaults::Disarm();
    refused += count.IsOk() ? 0 : 1;
    if (count.IsOk())
    {
      EXPECT_EQ(*count, triangles) << "operation " << operation;
    }
    else
    {
      ExpectMessage(count.GetStatus(), this->Folder);
    }
    EXPECT_EQ(Require(this->CountTriangles()), triangles);
  }
  EXPECT_GT(refused, 5u);
}
