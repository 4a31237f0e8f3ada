// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ParallelQueue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace isosurface;

namespace
{

/// The numbers below an end, in batches of 0 to 4 (never 0 before the end).
std::function<std::vector<std::size_t>()> CountTo(std::size_t end, std::size_t& next)
{
  return [end, &next]
  {
    std::vector<std::size_t> batch;
    for (std::size_t left = 1 + next % 4; left > 0 && next < end; --left)
    {
      batch.push_back(next++);
    }
    return batch;
  };
}

} // namespace

TEST(ParallelQueue, VisitsEachTakenIndexOnceOnAnyNumberOfThreads)
{
  for (const int threads : { 1, 2, 7 })
  {
    std::vector<std::atomic<int>> visits(1000);
    std::size_t next = 0;
    EXPECT_TRUE(ParallelQueue(CountTo(visits.size(), next), visits.size(), threads,
      [&](std::size_t index, int thread)
      {
        EXPECT_LT(thread, threads);
        ++visits[index];
      }));
    for (const auto& visit : visits)
    {
      EXPECT_EQ(visit, 1);
    }
  }
}

TEST(ParallelQueue, TakesInTheCallingThreadAndOnlyWhatIsNeededSoon)
{
  const std::thread::id caller = std::this_thread::get_id();
  std::size_t taken = 0;
  std::atomic<std::size_t> done{ 0 };
  EXPECT_TRUE(ParallelQueue(
    [&]
    {
      EXPECT_EQ(std::this_thread::get_id(), caller);
      EXPECT_LE(taken - done, 7u) << "2 * 3 - 1 wait, and two are in the hands of other threads";
      return taken < 100 ? std::vector<std::size_t>{ taken++ } : std::vector<std::size_t>();
    },
    100, 3, [&](std::size_t, int) { ++done; }));
  EXPECT_EQ(done, 100u);
}

TEST(ParallelQueue, WithoutIndicesItOnlyReportsTheEnd)
{
  std::vector<double> fractions;
  EXPECT_TRUE(ParallelQueue([] { return std::vector<std::size_t>(); }, 0, 3,
    [](std::size_t, int) { ADD_FAILURE(); },
    [&](double fraction)
    {
      fractions.push_back(fraction);
      return true;
    }));
  EXPECT_EQ(fractions, std::vector<double>{ 1 });
}

// The calling thread works until it has been asked whether to go on.
TEST(ParallelQueue, EndsWhenProgressSaysSo)
{
  std::atomic<bool> isAsked{ false };
  std::size_t taken = 0;
  EXPECT_FALSE(ParallelQueue([&] { return std::vector<std::size_t>{ taken++ }; }, 10, 2,
    [](std::size_t, int) { std::this_thread::yield(); },
    [&](double fraction)
    {
      EXPECT_GE(fraction, 0);
      EXPECT_LE(fraction, 1);
      isAsked = true;
      return false;
    }));
  EXPECT_TRUE(isAsked);
}

TEST(ParallelQueue, RethrowsWhatAThreadThrows)
{
  for (const int thrower : { 0, 1 })
  {
    std::size_t taken = 0;
    EXPECT_THROW(ParallelQueue([&] { return std::vector<std::size_t>{ taken++ }; }, 10, 2,
                   [&](std::size_t, int thread)
                   {
                     if (thread == thrower)
                     {
                       throw std::runtime_error("no medium");
                     }
                   }),
      std::runtime_error);
  }
  EXPECT_THROW(ParallelQueue([]() -> std::vector<std::size_t> { throw std::bad_alloc(); }, 10, 2,
                 [](std::size_t, int) {}),
    std::bad_alloc);
}
