// SPDX-License-Identifier: BSD-3-Clause
// One rank of several that runs out of memory for the messages of MPI, at each of its larger buffers:
// all ranks end with the same error, none waits, and the next try succeeds.
#include "RankGroup.h"

#include "ControllerCommunicator.h"
#include "ScratchFolder.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/MemoryShortage.h"
#include "Fixtures/Require.h"
#include "Fixtures/TestBlockSource.h"
#include "Formats/Indexing/GrowingIndex.h"
#include "Formats/Indexing/SourceSampler.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Verification/VolumeVerification.h"

#include <filesystem>
#include <fstream>
#include <functional>

using namespace isosurface;

namespace
{

/// The ranks of MPI, of which this one lacks memory for one of its buffers.
class StarvedRanks : public ControllerCommunicator
{
public:
  /// `buffer`: its number, from 0; below 0: none.
  explicit StarvedRanks(long buffer)
    : ControllerCommunicator(::GetRanks())
    , IsStarved(buffer >= 0)
    , Left(buffer)
  {
  }

  void ReduceMinimum(std::vector<std::uint64_t>& values) override
  {
    const Hunger hunger(this->Left);
    this->ControllerCommunicator::ReduceMinimum(values);
  }
  void ReduceMaximum(std::vector<std::uint64_t>& values) override
  {
    const Hunger hunger(this->Left);
    this->ControllerCommunicator::ReduceMaximum(values);
  }
  void ReduceSum(std::vector<std::uint64_t>& values) override
  {
    const Hunger hunger(this->Left);
    this->ControllerCommunicator::ReduceSum(values);
  }
  std::vector<Message> AllGather(const Message& mine) override
  {
    const Hunger hunger(this->Left);
    return this->ControllerCommunicator::AllGather(mine);
  }
  std::vector<Message> Exchange(std::vector<Message> outgoing) override
  {
    const Hunger hunger(this->Left);
    return this->ControllerCommunicator::Exchange(std::move(outgoing));
  }

  bool HasLacked() const { return this->IsStarved && this->Left < 0; }

private:
  /// While a collective lasts.
  class Hunger
  {
  public:
    explicit Hunger(long& left)
      : Left(left)
      , Shortage(left, MemoryShortage::Of::Thread)
    {
    }
    ~Hunger() { this->Left -= MemoryShortage::Count(); }

  private:
    long& Left;
    MemoryShortage Shortage;
  };

  bool IsStarved;
  long Left;
};

/// A folder that all ranks see, which the first one makes and removes.
class CommonFolder
{
public:
  CommonFolder()
    : Path((std::filesystem::current_path() / ("messages-" + std::to_string(GetNumberOfRanks()))))
  {
    OnFirstRank(
      [this]
      {
        std::filesystem::remove_all(this->Path);
        std::filesystem::create_directories(this->Path);
      });
  }
  ~CommonFolder()
  {
    OnFirstRank([this] { std::filesystem::remove_all(this->Path); });
  }
  std::string GetPath(const std::string& name) const { return (this->Path / name).string(); }

private:
  std::filesystem::path Path;
};

using Deed = std::function<Status(Communicator& ranks)>;

/// Expects all ranks to have the same error whichever buffer one of them lacks, every `step`-th of
/// them, and none without.
void ForEachBuffer(const std::string& path, long step, const Deed& deed)
{
  for (const int odd : { 0, GetNumberOfRanks() - 1 })
  {
    std::uint64_t lacked = 1;
    long buffer = odd % step;
    for (; lacked != 0 && buffer < 1000; buffer += step)
    {
      StarvedRanks ranks(GetRank() == odd ? buffer : -1);
      const Status status = deed(ranks);
      lacked = SumOverRanks(ranks.HasLacked() ? 1 : 0);
      const std::string expected =
        lacked == 0 ? "" : path + ": a rank has not enough memory for the messages between ranks";
      EXPECT_EQ(status.GetMessage(), expected) << "buffer " << buffer << " of rank " << odd;
      EXPECT_EQ(status.GetCode(), lacked == 0 ? StatusCode::Ok : StatusCode::OutOfMemory);
    }
    EXPECT_GT(buffer, 3) << "the test watches nothing";
  }
}

SampleVolume<std::uint8_t> MakeMessageVolume(const Index3& size)
{
  return SampleVolume<std::uint8_t>(
    size, [](auto i, auto j, auto k) { return (i * i + j * j + k * k) / 50; });
}

/// An index that is written of samples in a folder that all ranks see, and a sample of them.
struct IndexOfMessages
{
  explicit IndexOfMessages(const Index3& size)
    : Index{ this->Source + ":" + std::to_string(size[0]) + "x" + std::to_string(size[1]) + "x" +
        std::to_string(size[2]) + ",uint8",
      "", this->Folder.GetPath("source.bvol") }
  {
    OnFirstRank(
      [&]
      {
        const SampleVolume<std::uint8_t> volume = MakeMessageVolume(size);
        std::ofstream(this->Source, std::ios::binary)
          .write(reinterpret_cast<const char*>(volume.Samples.data()),
            static_cast<std::streamsize>(volume.Samples.size()));
      });
    this->Sample = Require(ReadSourceSample(this->All, this->Files, this->Index, {}));
  }

  const CommonFolder Folder;
  const std::string Source = this->Folder.GetPath("source.raw");
  const SourceIndex Index;
  FileSystem& Files = GetLocalFileSystem();
  ControllerCommunicator All{ GetRanks() };
  SourceSample Sample;
};

} // namespace

TEST(MessageMemory, AnIndexThatGrowsInTheBackgroundFailsOnAllRanks)
{
  // So many blocks that what a round tells of them is a large message.
  const IndexOfMessages of({ 420, 330, 3 });
  // Ranks that share a core wait long for each other.
  ForEachBuffer(of.Index.Path, LongTests ? 1 : 4,
    [&](Communicator& ranks)
    {
      GrowingIndex growing(ranks, of.Files, of.Index, of.Sample, std::uint64_t{ 64 } << 20);
      return growing.Finish(ranks, {});
    });
  OnFirstRank(
    [&]
    {
      const auto found =
        Require(VerifyBlockedVolume(of.Index.Path, of.Files, 1, {}, OpenForeignVolume));
      EXPECT_TRUE(found.Faults.empty());
    });
}

TEST(MessageMemory, ALargerSampleFailsOnAllRanks)
{
  IndexOfMessages of({ 200, 150, 3 }); // more than FewBytes
  of.Sample.Share = 0.01; // as if it were of a part of the file
  ForEachBuffer(of.Index.Source, 1,
    [&](Communicator& ranks)
    {
      GrowingIndex growing(of.All, of.Files, of.Index, of.Sample, std::uint64_t{ 64 } << 20);
      EXPECT_TRUE(growing.Finish(of.All, {}).IsOk());
      while (!growing.HasLargerSample(ranks))
      {
      }
      return growing.EnlargeSample(ranks);
    });
}

TEST(MessageMemory, TheRoundsOfAnEdgeIndexFileFailOnAllRanks)
{
  const CommonFolder folder;
  const std::string path = folder.GetPath("surface.eix");
  const SampleVolume<std::uint8_t> volume = MakeMessageVolume({ 150, 130, 110 }); // more than FewBytes
  FileSystem& files = GetLocalFileSystem();
  ForEachBuffer(path, 1,
    [&](Communicator& ranks)
    {
      TestBlockSource<std::uint8_t> source(volume, 16);
      std::vector<std::int64_t> numbers;
      for (const std::int64_t block : std::exchange(source.Blocks, {}))
      {
        if (block % ranks.GetSize() == ranks.GetRank())
        {
          source.Blocks.push_back(block);
          numbers.push_back(block);
        }
      }
      EdgeIndexHeader header;
      header.Geometry = volume.Geometry;
      header.Type = ValueType::UInt8;
      header.Isovalues = { 20, 40, 60, 80, 100, 120, 140, 160, 180, 200 };
      return EdgeIndexWriteJob(
        ranks, files, path, header, source, numbers, { 1, std::uint64_t{ 1 } << 20 })
        .Run()
        .GetStatus();
    });
}
