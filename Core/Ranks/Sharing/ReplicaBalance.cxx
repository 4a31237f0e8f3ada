// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/ReplicaBalance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace isosurface
{
namespace
{

constexpr std::size_t None = std::numeric_limits<std::size_t>::max();

/// The loads of servers, evened out step by step.
class Balance
{
public:
  Balance(const std::vector<std::uint64_t>& work,
    const std::vector<std::vector<ReplicaServer>>& servers, std::size_t count, double tolerance)
    : Servers(servers)
    , Loads(count, 0)
    , Stores(count)
  {
    std::uint64_t sum = 0;
    for (std::size_t store = 0; store < servers.size(); ++store)
    {
      this->Shares.emplace_back(servers[store].size(), 0);
      this->Shares[store].front() = work[store];
      this->Loads[servers[store].front().Server] += work[store];
      sum += work[store];
      for (const ReplicaServer& server : servers[store])
      {
        this->Stores[server.Server].push_back(store);
      }
    }
    // A server without any store, as after a loss, takes no part in the mean.
    const auto idle = std::count_if(this->Stores.begin(), this->Stores.end(),
      [](const std::vector<std::size_t>& stores) { return stores.empty(); });
    this->Mean = sum / std::max<std::uint64_t>(1, count - static_cast<std::size_t>(idle));
    this->Enough =
      this->Mean + static_cast<std::uint64_t>(tolerance * static_cast<double>(this->Mean));
    constexpr std::uint64_t leastShare = 256;
    this->Least = std::max<std::uint64_t>(2, this->Mean / leastShare);
  }

  std::vector<std::vector<std::uint64_t>> Run()
  {
    std::vector<bool> isSettled(this->Loads.size(), false);
    constexpr std::size_t stepsOfServer = 64;
    for (std::size_t step = 0; step < stepsOfServer * this->Loads.size(); ++step)
    {
      const std::size_t fullest = this->FindFullest(isSettled);
      if (fullest == None || this->Loads[fullest] <= this->Enough)
      {
        break;
      }
      this->Search(fullest);
      const std::size_t emptiest = this->FindEmptiest();
      if (this->Loads[fullest] < this->Loads[emptiest] + this->Least)
      {
        // Nobody whom its work could go to has less, and they can give to each other alone.
        for (const std::size_t server : this->Reached)
        {
          isSettled[server] = true;
        }
        continue;
      }
      this->Push(fullest, emptiest);
    }
    return std::move(this->Shares);
  }

private:
  /// A step on a way that work can go: a server gives it to the next one.
  struct Step
  {
    std::size_t From = None;
    std::size_t Store = None;
    std::size_t Giver = 0; ///< indices into the store's servers
    std::size_t Taker = 0;
  };

  std::size_t FindFullest(const std::vector<bool>& isSettled) const
  {
    std::size_t fullest = None;
    for (std::size_t server = 0; server < this->Loads.size(); ++server)
    {
      if (!isSettled[server] && (fullest == None || this->Loads[server] > this->Loads[fullest]))
      {
        fullest = server;
      }
    }
    return fullest;
  }

  /// Finds all servers that work of one can go to, by the shortest ways.
  void Search(std::size_t from)
  {
    this->Steps.assign(this->Loads.size(), {});
    this->Reached.assign(1, from);
    for (std::size_t next = 0; next < this->Reached.size(); ++next)
    {
      const std::size_t server = this->Reached[next];
      for (const std::size_t store : this->Stores[server])
      {
        this->Visit(from, server, store);
      }
    }
  }

  void Visit(std::size_t from, std::size_t server, std::size_t store)
  {
    const std::vector<ReplicaServer>& servers = this->Servers[store];
    std::size_t giver = 0;
    while (servers[giver].Server != server)
    {
      ++giver;
    }
    for (std::size_t taker = 0; this->Shares[store][giver] > 0 && taker < servers.size(); ++taker)
    {
      const std::size_t to = servers[taker].Server;
      if (to != from && this->Steps[to].From == None)
      {
        this->Steps[to] = { server, store, giver, taker };
        this->Reached.push_back(to);
      }
    }
  }

  std::size_t FindEmptiest() const
  {
    return *std::min_element(this->Reached.begin(), this->Reached.end(),
      [&](std::size_t a, std::size_t b) { return this->Loads[a] < this->Loads[b]; });
  }

  /// Moves half of the difference, or what is above the mean, or what the way allows.
  void Push(std::size_t from, std::size_t to)
  {
    std::uint64_t amount = (this->Loads[from] - this->Loads[to]) / 2;
    amount = std::min(amount, std::max(this->Least, this->Loads[from] - this->Mean));
    for (std::size_t at = to; at != from; at = this->Steps[at].From)
    {
      const Step& step = this->Steps[at];
      amount = std::min(amount, this->Shares[step.Store][step.Giver]);
    }
    for (std::size_t at = to; at != from; at = this->Steps[at].From)
    {
      const Step& step = this->Steps[at];
      this->Shares[step.Store][step.Giver] -= amount;
      this->Shares[step.Store][step.Taker] += amount;
    }
    this->Loads[from] -= amount;
    this->Loads[to] += amount;
  }

  const std::vector<std::vector<ReplicaServer>>& Servers;
  std::vector<std::uint64_t> Loads;
  std::vector<std::vector<std::size_t>> Stores; ///< per server: those that it has replicas of
  std::vector<std::vector<std::uint64_t>> Shares;
  std::uint64_t Mean = 0;
  std::uint64_t Enough = 0; ///< the maximum that need not be lower
  std::uint64_t Least = 1;  ///< the difference that is not worth a step
  std::vector<Step> Steps;  ///< per server: how work gets there
  std::vector<std::size_t> Reached;
};

} // namespace

std::vector<std::vector<std::uint64_t>> BalanceReplicas(const std::vector<std::uint64_t>& work,
  const std::vector<std::vector<ReplicaServer>>& servers, std::size_t count, double tolerance)
{
  return Balance(work, servers, count, tolerance).Run();
}

double FindTolerance(std::uint64_t blocks, std::size_t servers)
{
  constexpr double least = 1.0 / 256;
  // Measured: a lower one makes even stores uneven, a higher one leaves more of a lost store's
  // work.
  constexpr double spread = 0.5;
  return std::max(least,
    spread * std::sqrt(static_cast<double>(servers) / std::max(1.0, static_cast<double>(blocks))));
}

std::vector<std::uint32_t> ShareBlocks(
  const std::vector<std::uint32_t>& ordinals, const std::vector<std::uint64_t>& shares)
{
  std::vector<std::uint32_t> order(ordinals.size());
  std::iota(order.begin(), order.end(), 0U);
  // Multiples of the golden ratio: any part of the ordinals is mixed evenly.
  const auto mix = [&](std::uint32_t index) { return ordinals[index] * 2654435769U; };
  std::sort(
    order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return mix(a) < mix(b); });
  const double sum =
    static_cast<double>(std::accumulate(shares.begin(), shares.end(), std::uint64_t{ 0 }));
  std::vector<std::uint32_t> result(ordinals.size(), 0);
  double before = 0;
  std::size_t begin = 0;
  for (std::size_t share = 0; share < shares.size() && sum > 0; ++share)
  {
    before += static_cast<double>(shares[share]);
    const auto end = share + 1 == shares.size()
      ? order.size()
      : std::min(order.size(),
          static_cast<std::size_t>(before / sum * static_cast<double>(order.size()) + 0.5));
    for (; begin < end; ++begin)
    {
      result[order[begin]] = static_cast<std::uint32_t>(share);
    }
  }
  return result;
}

} // namespace isosurface
