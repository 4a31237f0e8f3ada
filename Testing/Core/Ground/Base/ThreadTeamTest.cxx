// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ThreadTeam.h"

#include "Ground/Base/ParallelFor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>
#include <thread>

using namespace isosurface;

TEST(ThreadTeam, KeepsItsThreadsForTheNextWork)
{
  std::set<std::thread::id> threads;
  const ThreadTeam team;
  for (int round = 0; round < 50; ++round)
  {
    threads.insert(StartTask([] { return std::this_thread::get_id(); }).Get());
  }
  EXPECT_EQ(threads.count(std::this_thread::get_id()), 0u);
  // The thread may need a moment before it waits for the next work.
  EXPECT_LT(threads.size(), 50u);
}

TEST(ThreadTeam, StartsWorkWhileAllItsThreadsAreBusy)
{
  const ThreadTeam team;
  std::promise<void> release;
  const std::shared_future<void> isReleased = release.get_future().share();
  std::vector<Task<void>> waiting;
  for (int task = 0; task < 5; ++task)
  {
    waiting.push_back(StartTask([isReleased] { isReleased.wait(); }));
  }
  EXPECT_EQ(StartTask([] { return 7; }).Get(), 7);
  release.set_value();
}

TEST(ThreadTeam, IsThatOfTheThreadThatMadeIt)
{
  EXPECT_EQ(ThreadTeam::OfThisThread(), nullptr);
  {
    const ThreadTeam team;
    EXPECT_EQ(ThreadTeam::OfThisThread(), &team);
    const ThreadTeam inner;
    EXPECT_EQ(ThreadTeam::OfThisThread(), &team);
    EXPECT_EQ(StartTask([] { return ThreadTeam::OfThisThread(); }).Get(), nullptr);
  }
  EXPECT_EQ(ThreadTeam::OfThisThread(), nullptr);
}

TEST(ThreadTeam, WorksForParallelForAndHandsOnExceptions)
{
  const ThreadTeam team;
  std::atomic<int> sum{ 0 };
  for (int round = 0; round < 20; ++round)
  {
    EXPECT_TRUE(ParallelFor(100, 4, [&](std::size_t, int) { ++sum; }));
  }
  EXPECT_EQ(sum, 2000);
  EXPECT_THROW(ParallelFor(100, 4,
                 [](std::size_t index, int)
                 {
                   if (index == 50)
                   {
                     throw std::runtime_error("stop");
                   }
                 }),
    std::runtime_error);
  auto task = StartTask([]() -> int { throw std::runtime_error("stop"); });
  EXPECT_THROW(task.Get(), std::runtime_error);
}

TEST(ThreadTeam, TasksAreWaitedForUnlessTheyAreDeferred)
{
  for (const bool isAhead : { true, false })
  {
    bool isDone = false;
    {
      const auto task = StartTask([&] { isDone = true; }, isAhead);
    }
    EXPECT_EQ(isDone, isAhead);
  }
}
