// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ParallelFor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace isosurface;

TEST(ParallelFor, VisitsEachIndexOnceOnAnyNumberOfThreads)
{
  for (const int threads : { 1, 2, 7 })
  {
    std::vector<std::atomic<int>> visits(1000);
    EXPECT_TRUE(ParallelFor(visits.size(), threads,
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

// The calling thread holds its first index until the other thread has done all others.
TEST(ParallelFor, ReportsTheEndWhenTheOtherThreadsDidTheWork)
{
  for (const bool goOn : { true, false })
  {
    std::atomic<int> done{ 0 };
    std::vector<double> fractions;
    const bool finished = ParallelFor(
      100, 2,
      [&](std::size_t, int thread)
      {
        while (thread == 0 && done < 99)
        {
          std::this_thread::yield();
        }
        ++done;
      },
      [&](double fraction)
      {
        fractions.push_back(fraction);
        return goOn || fraction < 1;
      });
    EXPECT_EQ(done, 100);
    EXPECT_EQ(finished, goOn);
    ASSERT_FALSE(fractions.empty());
    EXPECT_EQ(fractions.back(), 1);
  }
}

TEST(ParallelFor, StopsWhenAskedTo)
{
  std::atomic<int> done{ 0 };
  EXPECT_FALSE(ParallelFor(
    1000, 1, [&](std::size_t, int) { ++done; }, [](double) { return false; }));
  EXPECT_EQ(done, 1);
  EXPECT_TRUE(ParallelFor(
    0, 2, [&](std::size_t, int) { ++done; }, [](double) { return false; }));
  EXPECT_EQ(done, 1);
}

TEST(ParallelFor, StopsSoonWhereIndicesTakeLong)
{
  std::atomic<int> done{ 0 };
  EXPECT_FALSE(ParallelFor(
    100'000, 1,
    [&](std::size_t, int)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ++done;
    },
    [&](double fraction) { return fraction < 0; }));
  EXPECT_LT(done, 100) << "a hundredth of the indices would be 1000";
}

TEST(ParallelFor, RethrowsAnExceptionOfTheBody)
{
  EXPECT_THROW(ParallelFor(100, 3,
                 [](std::size_t index, int)
                 {
                   if (index == 50)
                   {
                     throw std::runtime_error("no");
                   }
                 }),
    std::runtime_error);
}
