// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/ReplicaBalance.h"

#include "Storage/Store/StoreFaults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

using namespace isosurface;

namespace
{

using Work = std::vector<std::uint64_t>;
using Servers = std::vector<std::vector<ReplicaServer>>;

// Store d is served by the hosts d ... d + replicas - 1, but for lost ones.
Servers MakeChain(std::uint32_t stores, std::uint32_t replicas, std::int64_t lost = -1)
{
  Servers servers(stores);
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    for (std::uint32_t replica = 0; replica < replicas; ++replica)
    {
      const std::uint32_t host = (store + replica) % stores;
      if (host != lost)
      {
        servers[store].push_back({ host, replica });
      }
    }
  }
  return servers;
}

// The load of each server; the shares of a store add up to its work.
Work FindLoads(const Work& work, const Servers& servers, std::size_t count)
{
  const auto shares = BalanceReplicas(work, servers, count);
  Work loads(count, 0);
  for (std::size_t store = 0; store < work.size(); ++store)
  {
    EXPECT_EQ(
      std::accumulate(shares[store].begin(), shares[store].end(), std::uint64_t{ 0 }), work[store]);
    for (std::size_t server = 0; server < servers[store].size(); ++server)
    {
      loads[servers[store][server].Server] += shares[store][server];
    }
  }
  return loads;
}

double FindRatio(const Work& loads, std::size_t servers)
{
  const auto sum = std::accumulate(loads.begin(), loads.end(), std::uint64_t{ 0 });
  return static_cast<double>(*std::max_element(loads.begin(), loads.end())) *
    static_cast<double>(servers) / static_cast<double>(sum);
}

// The least maximum there can be: any stores that follow each other have only so many hosts.
double FindBound(const Work& work, std::uint32_t replicas)
{
  const std::size_t stores = work.size();
  const double mean =
    static_cast<double>(std::accumulate(work.begin(), work.end(), std::uint64_t{ 0 })) /
    static_cast<double>(stores);
  double bound = 1;
  for (std::size_t first = 0; first < stores; ++first)
  {
    double sum = 0;
    for (std::size_t count = 1; count + replicas - 1 < stores; ++count)
    {
      sum += static_cast<double>(work[(first + count - 1) % stores]);
      bound = std::max(bound, sum / static_cast<double>(count + replicas - 1) / mean);
    }
  }
  return bound;
}

} // namespace

TEST(ReplicaBalance, ReachesTheLeastMaximumOfAnyWork)
{
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round)
  {
    const std::uint32_t stores = 3 + random() % 60;
    const std::uint32_t replicas = std::min<std::uint32_t>(stores, 2 + random() % 3);
    Work work;
    for (std::uint32_t store = 0; store < stores; ++store)
    {
      work.push_back(random() % 4 == 0 ? random() % 400000 : random() % 10000 + 1);
    }
    const Work loads = FindLoads(work, MakeChain(stores, replicas), stores);
    EXPECT_LE(FindRatio(loads, stores), FindBound(work, replicas) + 0.02)
      << stores << ", " << replicas;
  }
}

TEST(ReplicaBalance, ALostServerCostsAllOthersTheSame)
{
  const Work work(32, 100000);
  const Work loads = FindLoads(work, MakeChain(32, 2, 7), 32);
  EXPECT_EQ(loads[7], 0u);
  EXPECT_LE(FindRatio(loads, 31), 1.02);
}

TEST(ReplicaBalance, WhatIsEvenStaysWithTheFirstServers)
{
  const Work work(8, 1000);
  for (const auto& shares : BalanceReplicas(work, MakeChain(8, 3), 8))
  {
    EXPECT_EQ(shares, (Work{ 1000, 0, 0 }));
  }
}

TEST(ReplicaBalance, BlocksGoByTheSharesAndSeldomMove)
{
  std::vector<std::uint32_t> ordinals(1000);
  std::iota(ordinals.begin(), ordinals.end(), 0U);
  const auto before = ShareBlocks(ordinals, { 700, 0, 300 });
  EXPECT_EQ(std::count(before.begin(), before.end(), 0U), 700);
  EXPECT_EQ(std::count(before.begin(), before.end(), 2U), 300);
  // Each tenth of the blocks is shared alike.
  for (std::size_t begin = 0; begin < 1000; begin += 100)
  {
    const auto first = before.begin() + static_cast<std::ptrdiff_t>(begin);
    EXPECT_NEAR(static_cast<double>(std::count(first, first + 100, 0U)), 70, 3);
  }
  const auto after = ShareBlocks(ordinals, { 720, 0, 280 });
  std::size_t moved = 0;
  for (std::size_t block = 0; block < 1000; ++block)
  {
    moved += before[block] != after[block] ? 1 : 0;
  }
  EXPECT_EQ(moved, 20u);
  EXPECT_TRUE(ShareBlocks({}, { 1, 2 }).empty());
  EXPECT_EQ(ShareBlocks({ 5 }, { 0, 0 }), std::vector<std::uint32_t>{ 0 });
}

TEST(StoreFaults, WhatOneRankFindsIsCommonOnlyWhenTheRanksHaveJoined)
{
  StoreFaults here;
  StoreFaults there;
  const StoreReplica replica = { 0, 0, 3, 1 };
  here.Add({ replica, 17, "damaged" });
  here.Add({ replica, 17, "damaged" });
  EXPECT_EQ(here.GetState(replica, false), ReplicaState::Damaged);
  EXPECT_EQ(here.GetState(replica, false, 17), ReplicaState::Lost);
  EXPECT_EQ(here.GetState(replica, true, 17), ReplicaState::Sound);
  const std::vector<Message> messages = { here.Pack(), there.Pack() };
  const auto news = here.Join(messages);
  ASSERT_EQ(news.size(), 1u);
  EXPECT_EQ(news[0].Reason, "damaged");
  EXPECT_EQ(there.Join(messages).size(), 1u);
  EXPECT_EQ(there.GetState(replica, true, 17), ReplicaState::Lost);
  EXPECT_EQ(there.GetState(replica, true, 18), ReplicaState::Damaged);
  EXPECT_EQ(there.GetState({ 0, 0, 3, 0 }, true), ReplicaState::Sound);
  EXPECT_TRUE(here.Join(messages).empty());
}
