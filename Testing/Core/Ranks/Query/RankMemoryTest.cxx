// SPDX-License-Identifier: BSD-3-Clause
// One rank of several that runs out of memory, at each of its larger allocations: all ranks end with
// an error, none waits. In a process for each, since whatever was begun then is left.
#include "RankDeeds.h"

#include "Fixtures/MemoryShortage.h"
#include "Ground/Base/KeptMemory.h"

#include <atomic>
#include <functional>
#include <optional>

#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

using Deed = std::function<Status(Communicator& ranks, FileSystem& disk)>;

enum Outcome : int
{
  AllFailed,
  AllSucceeded,
  RanksDiffer,
  NothingFailed ///< there are not so many allocations
};

class RankWithoutMemory : public testing::TestWithParam<int>
{
protected:
  void SetUp() override
  {
    WriteVolumeOk(this->Disk, RankDeeds::GetSamples(), MakeSettings(16, 3), 1);
    ASSERT_TRUE(this->Disk.MakeDirectories("/data").IsOk());
    RankDeeds::GetOther();
  }

  Outcome Run(const Deed& deed, int odd, long allocation)
  {
    const int ranks = GetParam();
    std::atomic<int> successes{ 0 };
    std::atomic<bool> hasFailed{ false };
    ThreadCommunicator::Run(ranks,
      [&](Communicator& communicator)
      {
        const bool isOdd = communicator.GetRank() == odd;
        std::optional<MemoryShortage> shortage;
        if (isOdd)
        {
          shortage.emplace(allocation, MemoryShortage::Of::Thread);
        }
        const Status status =
          RunCollective("the deed fails", [&] { return deed(communicator, this->Disk); });
        if (isOdd)
        {
          shortage.reset();
          hasFailed = MemoryShortage::Count() > allocation;
        }
        successes += status.IsOk() ? 1 : 0;
      });
    return !hasFailed      ? NothingFailed
      : successes == 0     ? AllFailed
      : successes == ranks ? AllSucceeded
                           : RanksDiffer;
  }

  /// The outcome in a process of its own; below 0 if that was killed by a signal.
  int RunAlone(const Deed& deed, int odd, long allocation)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      ::alarm(30); // ranks that wait for each other
      ::_exit(this->Run(deed, odd, allocation));
    }
    int state = 0;
    EXPECT_EQ(::waitpid(child, &state, 0), child);
    return WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
  }

  /// `own`: the allocations of the deed itself, before Core's.
  void ForEachAllocation(const Deed& deed, long own)
  {
    for (const int odd : { 0, GetParam() - 1 })
    {
      int outcome = AllFailed;
      long allocation = own;
      for (; outcome != NothingFailed && allocation < 2000; ++allocation)
      {
        outcome = this->RunAlone(deed, odd, allocation);
        ASSERT_TRUE(outcome == AllFailed || outcome == AllSucceeded || outcome == NothingFailed)
          << outcome << " at allocation " << allocation << " of rank " << odd;
      }
      EXPECT_GT(allocation, own + 5) << "the test watches nothing";
    }
  }

  MemoryDisk Disk;
};

} // namespace

TEST_P(RankWithoutMemory, FailsWithAllWhenWritingAVolume)
{
  this->ForEachAllocation(RankDeeds::WriteVolume, 1);
}

TEST_P(RankWithoutMemory, FailsWithAllWhenWritingAnEdgeIndexFile)
{
  this->ForEachAllocation(RankDeeds::WriteEdgeIndexFile, 0);
}

TEST_P(RankWithoutMemory, FailsWithAllWithinABudget)
{
  this->ForEachAllocation(RankDeeds::ExtractWithinBudget, 0);
}

TEST_P(RankWithoutMemory, FailsWithAllWhenDistributing)
{
  this->ForEachAllocation(RankDeeds::Distribute, 0);
}

TEST_P(RankWithoutMemory, FailsWithAllWhenCountingASpectrum)
{
  this->ForEachAllocation(RankDeeds::CountSpectrum, 1);
}

TEST_P(RankWithoutMemory, FailsWithAllWhenFindingIslands)
{
  this->ForEachAllocation(RankDeeds::FindIslands, 0);
}

INSTANTIATE_TEST_SUITE_P(
  Ranks, RankWithoutMemory, testing::ValuesIn(RankDeeds::GetNumbersOfRanks()));

TEST(KeptMemoryOfRanks, IsFreedWhereMemoryIsShort)
{
  constexpr std::size_t size = std::size_t(8) << 20;
  const auto keep = []
  {
    for (int n = 0; n < 16; ++n) // in each sixteen the available memory is asked for once
    {
      ReleaseMemory(TakeMemory(size));
    }
  };
  long allocations = 0;
  {
    const MemoryShortage none(-1);
    keep();
    allocations = MemoryShortage::Count();
  }
  const MemoryShortage shortage(allocations);
  keep();
  EXPECT_GE(GetKeptBytes(), size);
  void* const larger = TakeMemory(4 * size);
  EXPECT_GT(MemoryShortage::Count(), allocations + 1)
    << "nothing failed, or it was not tried again";
  EXPECT_NE(larger, nullptr);
  EXPECT_EQ(GetKeptBytes(), 0u);
  ReleaseMemory(larger);
}
