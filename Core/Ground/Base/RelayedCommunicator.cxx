// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/RelayedCommunicator.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace isosurface
{
namespace
{

/// Whether the work has ended is not notified, but asked for.
constexpr std::chrono::milliseconds AskInterval(10);

} // namespace

RelayedCommunicator::RelayedCommunicator(Communicator& ranks)
  : Rank(ranks.GetRank())
  , Size(ranks.GetSize())
  , RanksOnNode(ranks.GetRanksOnNode())
{
}

bool RelayedCommunicator::Serve(
  Communicator& ranks, double seconds, const std::function<bool()>& isEnded)
{
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() +
    std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  for (;;)
  {
    const Operation* operation = nullptr;
    {
      std::unique_lock<std::mutex> lock(this->Mutex);
      this->Changed.wait_until(lock, std::min(end, Clock::now() + AskInterval),
        [this] { return this->Waiting != nullptr; });
      operation = this->Waiting;
    }
    std::vector<std::uint64_t> all = { operation ? 1U : 0U, !operation && isEnded() ? 1U : 0U,
      Clock::now() < end ? 1U : 0U };
    ranks.ReduceMinimum(all);
    if (all[0] != 0)
    {
      bool lacksMemory = false;
      try
      {
        (*operation)(ranks);
      }
      catch (const NoMemoryForMessages&)
      {
        lacksMemory = true;
      }
      const std::lock_guard<std::mutex> lock(this->Mutex);
      this->LacksMemory = lacksMemory;
      this->Waiting = nullptr;
      this->Changed.notify_all();
    }
    if (all[1] != 0 || all[2] == 0)
    {
      return all[1] != 0;
    }
  }
}

void RelayedCommunicator::Close()
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->IsClosed = true;
  this->Changed.notify_all();
}

void RelayedCommunicator::Relay(const Operation& operation)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  this->Waiting = this->IsClosed ? nullptr : &operation;
  this->Changed.notify_all();
  this->Changed.wait(lock, [this] { return this->IsClosed || !this->Waiting; });
  if (this->IsClosed)
  {
    this->Waiting = nullptr;
    throw std::runtime_error("the ranks no longer work together");
  }
  if (std::exchange(this->LacksMemory, false))
  {
    throw NoMemoryForMessages();
  }
}

void RelayedCommunicator::ReduceMinimum(std::vector<std::uint64_t>& values)
{
  this->Relay([&](Communicator& ranks) { ranks.ReduceMinimum(values); });
}

void RelayedCommunicator::ReduceMaximum(std::vector<std::uint64_t>& values)
{
  this->Relay([&](Communicator& ranks) { ranks.ReduceMaximum(values); });
}

void RelayedCommunicator::ReduceSum(std::vector<std::uint64_t>& values)
{
  this->Relay([&](Communicator& ranks) { ranks.ReduceSum(values); });
}

std::vector<Message> RelayedCommunicator::AllGather(const Message& mine)
{
  std::vector<Message> all;
  this->Relay([&](Communicator& ranks) { all = ranks.AllGather(mine); });
  return all;
}

std::vector<Message> RelayedCommunicator::Exchange(std::vector<Message> outgoing)
{
  std::vector<Message> incoming;
  this->Relay([&](Communicator& ranks) { incoming = ranks.Exchange(std::move(outgoing)); });
  return incoming;
}

} // namespace isosurface
