// SPDX-License-Identifier: BSD-3-Clause
// One rank of several whose disk fails at any operation, between any two collectives: all ranks end
// with an error, none waits, and what was there before is there still.
#include "Fixtures/LongTests.h"
#include "RankDeeds.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Storage/Verification/VolumeVerification.h"

#include <atomic>
#include <functional>
#include <string>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

/// A disk as one rank sees it: the operation with a number fails, counted from 0. The disk behind it
/// is that of all ranks.
class OneRanksDisk : public FileSystem
{
public:
  OneRanksDisk(FileSystem& disk, std::uint64_t failing)
    : Disk(disk)
    , Failing(failing)
  {
  }
  bool HasFailed() const { return this->Count > this->Failing; }

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ask(path));
    ISOSURFACE_ASSIGN_OR_RETURN(auto file, this->Disk.OpenForReading(path));
    return std::unique_ptr<RandomAccessFile>(new Reader(*this, std::move(file)));
  }
  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    return this->Wrap(path, [&] { return this->Disk.CreateForWriting(path); });
  }
  Result<std::unique_ptr<WritableFile>> OpenForUpdate(const std::string& path) override
  {
    return this->Wrap(path, [&] { return this->Disk.OpenForUpdate(path); });
  }
  Status Rename(const std::string& from, const std::string& to) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ask(to));
    return this->Disk.Rename(from, to);
  }
  Status MakeDirectories(const std::string& path) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ask(path));
    return this->Disk.MakeDirectories(path);
  }
  Status RemoveAll(const std::string& path) override { return this->Disk.RemoveAll(path); }
  bool Exists(const std::string& path) override { return this->Disk.Exists(path); }
  Result<std::vector<std::string>> List(const std::string& path) override
  {
    return this->Disk.List(path);
  }
  Status SyncDirectory(const std::string& path) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ask(path));
    return this->Disk.SyncDirectory(path);
  }

private:
  Status Ask(const std::string& path)
  {
    return this->Count++ == this->Failing
      ? Status(StatusCode::IoError, path + ": cannot be used: Input/output error")
      : Status::Ok();
  }
  Result<std::unique_ptr<WritableFile>> Wrap(
    const std::string& path, const std::function<Result<std::unique_ptr<WritableFile>>()>& open)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ask(path));
    ISOSURFACE_ASSIGN_OR_RETURN(auto file, open());
    return std::unique_ptr<WritableFile>(new Writer(*this, std::move(file)));
  }

  struct Reader : public RandomAccessFile
  {
    Reader(OneRanksDisk& disk, std::unique_ptr<RandomAccessFile> file)
      : Disk(disk)
      , File(std::move(file))
    {
    }
    Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.Ask(this->GetPath()));
      return this->File->Read(offset, size, bytes);
    }
    std::uint64_t GetSize() const override { return this->File->GetSize(); }
    const std::string& GetPath() const override { return this->File->GetPath(); }
    OneRanksDisk& Disk;
    std::unique_ptr<RandomAccessFile> File;
  };

  struct Writer : public WritableFile
  {
    Writer(OneRanksDisk& disk, std::unique_ptr<WritableFile> file)
      : Disk(disk)
      , File(std::move(file))
    {
    }
    Status Append(const void* bytes, std::size_t size) override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.Ask(this->GetPath()));
      return this->File->Append(bytes, size);
    }
    Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.Ask(this->GetPath()));
      return this->File->WriteAt(offset, bytes, size);
    }
    std::uint64_t GetSize() const override { return this->File->GetSize(); }
    Status Sync() override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.Ask(this->GetPath()));
      return this->File->Sync();
    }
    Status SyncAndClose() override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.Ask(this->GetPath()));
      return this->File->SyncAndClose();
    }
    const std::string& GetPath() const override { return this->File->GetPath(); }
    OneRanksDisk& Disk;
    std::unique_ptr<WritableFile> File;
  };

  FileSystem& Disk;
  std::atomic<std::uint64_t> Count{ 0 };
  const std::uint64_t Failing;
};

using Deed = std::function<Status(Communicator& ranks, FileSystem& disk)>;

class RankFaults : public testing::TestWithParam<int>
{
protected:
  void SetUp() override
  {
    WriteVolumeOk(this->Disk, RankDeeds::GetSamples(), MakeSettings(16, 3), 1);
    ASSERT_TRUE(this->Disk.MakeDirectories("/data").IsOk());
  }

  /// Does something with each operation of one rank failing in turn: even ones of the first rank, odd
  /// ones of the last; in long tests all of both.
  void ForEachOperation(const Deed& deed, const std::function<void(bool isDone)>& look)
  {
    const int ranks = GetParam();
    for (const int odd : { 0, ranks - 1 })
    {
      bool isLast = false;
      // The more ranks there are, the fewer operations has each.
      for (std::uint64_t operation = LongTests || odd == 0 ? 0 : 1; !isLast;
           operation += LongTests ? 1 : 2)
      {
        std::vector<Status> outcomes(static_cast<std::size_t>(ranks));
        ThreadCommunicator::Run(ranks,
          [&](Communicator& communicator)
          {
            const int rank = communicator.GetRank();
            OneRanksDisk disk(this->Disk, rank == odd ? operation : MemoryDisk::Never);
            outcomes[static_cast<std::size_t>(rank)] = deed(communicator, disk);
            if (rank == odd) // the others must not touch it
            {
              isLast = !disk.HasFailed();
            }
          });
        SCOPED_TRACE("operation " + std::to_string(operation) + " of rank " + std::to_string(odd));
        this->ExpectAgreed(outcomes, isLast);
        look(outcomes.front().IsOk());
        if (HasFailure())
        {
          return;
        }
      }
    }
  }

  static void ExpectAgreed(const std::vector<Status>& outcomes, bool isLast)
  {
    for (const Status& status : outcomes)
    {
      EXPECT_EQ(status.IsOk(), outcomes.front().IsOk()) << status.GetMessage();
      EXPECT_TRUE(!isLast || status.IsOk()) << status.GetMessage();
      EXPECT_TRUE(status.IsOk() ||
        (status.GetMessage().find("/data") != std::string::npos &&
          status.GetMessage().find("Input/output error") != std::string::npos))
        << status.GetMessage();
    }
  }

  MemoryDisk Disk;
};

} // namespace

TEST_P(RankFaults, OfWritingAVolumeAreThoseOfAll)
{
  const auto before = this->Disk.Copy();
  const auto look = [&](bool isDone)
  {
    const auto found = VerifyBlockedVolume(VolumePath, this->Disk, 1);
    ASSERT_TRUE(found.IsOk() && found->Faults.empty()) << found->Faults.front().GetMessage();
    if (!isDone && this->Disk.GetFile(VolumePath) == before.at(VolumePath))
    {
      EXPECT_TRUE(this->Disk.Copy() == before) << "something is left over, or lost";
      return;
    }
    // The new volume is there: back to the old one.
    ASSERT_TRUE(this->Disk.RemoveAll(HidePath(VolumePath + ".stores")).IsOk());
    for (const auto& file : before)
    {
      ASSERT_TRUE(this->Disk.MakeDirectories(file.first.substr(0, file.first.rfind('/'))).IsOk());
      this->Disk.SetFile(file.first, file.second);
    }
  };
  this->ForEachOperation(RankDeeds::WriteVolume, look);
}

TEST_P(RankFaults, OfWritingAnEdgeIndexFileAreThoseOfAll)
{
  const std::string& path = RankDeeds::SurfacePath;
  this->Disk.SetFile(path, { 1, 2, 3 });
  const auto look = [&](bool isDone)
  {
    const MemoryDisk::Bytes bytes = this->Disk.GetFile(path);
    EXPECT_TRUE(!isDone || bytes.size() > 3);
    EXPECT_TRUE(bytes.size() == 3 || (*EdgeIndexFile::Open(this->Disk, path))->IsComplete());
    EXPECT_FALSE(this->Disk.Exists(path + ".part"));
    this->Disk.SetFile(path, { 1, 2, 3 });
  };
  this->ForEachOperation(RankDeeds::WriteEdgeIndexFile, look);
}

TEST_P(RankFaults, OfSurfacesWithinABudgetAreThoseOfAll)
{
  this->ForEachOperation(RankDeeds::ExtractWithinBudget, [](bool) {});
}

TEST_P(RankFaults, OfSurfacesThatAreDistributedAreThoseOfAll)
{
  this->ForEachOperation(RankDeeds::Distribute, [](bool) {});
}

INSTANTIATE_TEST_SUITE_P(Ranks, RankFaults, testing::ValuesIn(RankDeeds::GetNumbersOfRanks()));
