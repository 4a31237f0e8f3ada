// SPDX-License-Identifier: BSD-3-Clause
// Ranks that take blocks from each other's shares while they extract: all together have the surface
// that they have without, whoever is slow, fails or is stopped.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Ranks/Query/LevelExtraction.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>

using namespace isosurface;

namespace
{

constexpr double SharedIsovalue = 60;

/// Closed until a number of ranks have passed by.
class Gate
{
public:
  explicit Gate(int passers)
    : Left(passers)
  {
  }
  void PassBy()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    --this->Left;
    this->Changed.notify_all();
  }
  void WaitUntilOpen()
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    this->Changed.wait(lock, [this] { return this->Left <= 0; });
  }

private:
  std::mutex Mutex;
  std::condition_variable Changed;
  int Left;
};

/// What a rank has extracted.
struct RankResult
{
  Status End;
  PlainSurface Plain;
  std::uint64_t Blocks = 0;
  std::uint64_t Share = 0; ///< blocks of its own
};

class SharedExtraction : public ::testing::Test
{
protected:
  static void SetUpTestSuite()
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 93, 77, 61 }), MakeSettings(16, 3));
    Files = disk.Copy();
  }
  static void FillDisk(MemoryDisk& disk)
  {
    for (const auto& [path, bytes] : Files)
    {
      EXPECT_TRUE(disk.MakeDirectories(path.substr(0, path.rfind('/'))).IsOk());
      disk.SetFile(path, bytes);
    }
  }

  /// What happens on a rank: `begin` is called with its disk when the trees have been read.
  struct Deed
  {
    std::function<void(int rank, MemoryDisk& disk)> Begin;
    std::function<bool(int rank, double fraction)> Advance;
  };

  /// At each read the rank waits until the gate `next` is open; the first one passes `begin` before.
  static void StandAtReads(MemoryDisk& disk, bool isFirst, Gate& begin, Gate& next)
  {
    disk.SetBeforeRead(
      [isFirst, &begin, &next]
      {
        if (isFirst)
        {
          begin.PassBy();
        }
        next.WaitUntilOpen();
      });
  }

  static std::vector<RankResult> Run(
    int ranks, bool shares, const Deed& deed = {}, int threads = 1, int level = 0)
  {
    std::vector<RankResult> results(static_cast<std::size_t>(ranks));
    ThreadCommunicator::Run(ranks,
      [&](Communicator& communicator)
      {
        const int rank = communicator.GetRank();
        RankResult& result = results[static_cast<std::size_t>(rank)];
        MemoryDisk disk;
        FillDisk(disk);
        const auto volume = OpenVolume(disk);
        volume->SetLocalStores(false);
        SurfaceQuery query{ { 0, 0, { SharedIsovalue } }, rank, ranks };
        ContourRequest request = MakePlainRequest(query.Isovalues);
        QueryStatistics statistics;
        result.Share =
          FindActiveBlocks(*volume, { { 0, 0, query.Isovalues }, rank, ranks }, statistics, level)
            ->size();
        if (deed.Begin)
        {
          deed.Begin(rank, disk);
        }
        const auto advance = [&](double fraction)
        { return !deed.Advance || deed.Advance(rank, fraction); };
        ExtractionOutcome outcome;
        result.End = ExtractLevel(
          { volume, query, request, threads, advance, shares ? &communicator : nullptr }, level,
          outcome);
        result.Plain = MakePlain(outcome.Extracted);
        result.Blocks = outcome.Cost.Reading.ActiveBlocks;
      });
    return results;
  }

  static PlainSurface Unite(const std::vector<RankResult>& results)
  {
    std::vector<PlainSurface> parts;
    for (const RankResult& result : results)
    {
      EXPECT_TRUE(result.End.IsOk()) << result.End.GetMessage();
      parts.push_back(result.Plain);
    }
    return UniteRanks(parts);
  }

  static std::uint64_t CountBlocks(const std::vector<RankResult>& results)
  {
    std::uint64_t blocks = 0;
    for (const RankResult& result : results)
    {
      blocks += result.Blocks;
    }
    return blocks;
  }

  static inline std::map<std::string, MemoryDisk::Bytes> Files;
};

} // namespace

TEST_F(SharedExtraction, IsTheSurfaceOfOneRankOnAnyNumberOfRanksAndThreads)
{
  for (const int level : { 0, 1 })
  {
    const auto alone = Run(1, false, {}, 1, level);
    const PlainSurface whole = Unite(alone);
    for (const int ranks : GetNumbersOfRanks())
    {
      for (const int threads : { 1, 3 })
      {
        const auto results = Run(ranks, true, {}, threads, level);
        EXPECT_TRUE(Unite(results) == whole) << ranks << " ranks, level " << level;
        EXPECT_EQ(CountBlocks(results), alone.front().Blocks) << "each block once";
      }
    }
  }
}

// Rank 0 stands at its first block until the others are ready, which begin when it stands there.
TEST_F(SharedExtraction, OthersExtractAllButWhatAHeldRankHasClaimed)
{
  const auto alone = Run(1, false);
  const PlainSurface whole = Unite(alone);
  for (const int ranks : LongTests ? std::vector<int>{ 2, 3, 4, 7 } : std::vector<int>{ 2, 7 })
  {
    Gate begin(1);
    Gate end(ranks - 1);
    Deed deed;
    deed.Begin = [&](int rank, MemoryDisk& disk)
    { StandAtReads(disk, rank == 0, begin, rank == 0 ? end : begin); };
    std::vector<int> passes(static_cast<std::size_t>(ranks));
    deed.Advance = [&](int rank, double fraction)
    {
      // The first phase ends with this progress, when there are no more blocks.
      if (rank > 0 && fraction >= 0.5 && ++passes[static_cast<std::size_t>(rank)] == 1)
      {
        end.PassBy();
      }
      return true;
    };
    const auto results = Run(ranks, true, deed);
    EXPECT_TRUE(Unite(results) == whole) << ranks << " ranks";
    EXPECT_EQ(CountBlocks(results), alone.front().Blocks) << "each block once";
    const RankResult& held = results.front();
    EXPECT_GT(held.Blocks, 0u);
    EXPECT_LE(held.Blocks, std::max<std::uint64_t>(1, std::min<std::uint64_t>(4, held.Share / 16)));
    EXPECT_GT(held.Share, held.Blocks) << "there was something to take";
  }
}

// The others begin when rank 1 has blocks that nobody else will have.
TEST_F(SharedExtraction, AFailedRankIsAnErrorThatKeepsNobodyWaiting)
{
  for (const int ranks : LongTests ? std::vector<int>{ 2, 3, 4, 7 } : std::vector<int>{ 2, 7 })
  {
    Gate begin(1);
    Deed deed;
    deed.Begin = [&](int rank, MemoryDisk& disk)
    {
      StandAtReads(disk, rank == 1, begin, begin);
      if (rank == 1)
      {
        disk.FailFromRead(0);
      }
    };
    const auto results = Run(ranks, true, deed);
    for (int rank = 0; rank < ranks; ++rank)
    {
      EXPECT_EQ(results[static_cast<std::size_t>(rank)].End.IsOk(), rank != 1);
    }
  }
}

TEST_F(SharedExtraction, AFailedQueryIsAnErrorThatKeepsNobodyWaiting)
{
  ThreadCommunicator::Run(3,
    [&](Communicator& communicator)
    {
      MemoryDisk mine;
      FillDisk(mine);
      const auto volume = OpenVolume(mine);
      volume->SetLocalStores(false);
      SurfaceQuery query{ { 0, 0, { SharedIsovalue } }, communicator.GetRank(), 3 };
      if (query.Rank == 2)
      {
        mine.FailFromRead(0);
      }
      const ContourRequest request = MakePlainRequest(query.Isovalues);
      ExtractionOutcome outcome;
      const Status status =
        ExtractLevel({ volume, query, request, 1, {}, &communicator }, 0, outcome);
      EXPECT_EQ(status.IsOk(), query.Rank != 2);
    });
}

TEST_F(SharedExtraction, AnAbortedRankKeepsNobodyWaiting)
{
  for (const int ranks : { 2, 4 })
  {
    Deed deed;
    deed.Advance = [](int rank, double) { return rank != 0; };
    const auto results = Run(ranks, true, deed);
    EXPECT_EQ(results.front().End.GetCode(), StatusCode::Aborted);
    for (int rank = 1; rank < ranks; ++rank)
    {
      EXPECT_TRUE(results[static_cast<std::size_t>(rank)].End.IsOk());
    }
  }
}

TEST_F(SharedExtraction, RanksKeepTheirOwnBlocksWhereStoresAreLocalToOne)
{
  constexpr int ranks = 3;
  std::vector<std::uint64_t> blocks(ranks);
  std::vector<std::uint64_t> shares(ranks);
  ThreadCommunicator::Run(ranks,
    [&](Communicator& communicator)
    {
      MemoryDisk disk;
      FillDisk(disk);
      const int rank = communicator.GetRank();
      const auto volume = OpenVolume(disk);
      volume->SetLocalStores(rank == 1);
      SurfaceQuery query{ { 0, 0, { SharedIsovalue } }, rank, ranks };
      const ContourRequest request = MakePlainRequest(query.Isovalues);
      ExtractionOutcome outcome;
      EXPECT_TRUE(
        ExtractLevel({ volume, query, request, 1, {}, &communicator }, 0, outcome).IsOk());
      QueryStatistics statistics;
      blocks[static_cast<std::size_t>(rank)] = outcome.Cost.Reading.ActiveBlocks;
      shares[static_cast<std::size_t>(rank)] =
        FindActiveBlocks(*volume, { { 0, 0, query.Isovalues }, rank, ranks }, statistics)->size();
    });
  EXPECT_EQ(blocks, shares);
}
