// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_ThreadCommunicator_h
#define isosurface_Testing_ThreadCommunicator_h

#include "Ground/Base/Communicator.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace isosurface
{

/// Ranks that are threads of one process.
class ThreadCommunicator : public Communicator
{
public:
  /// Calls body(communicator) as each of `size` ranks at once, and waits for all.
  static void Run(int size, const std::function<void(Communicator&)>& body)
  {
    Group group(static_cast<std::size_t>(size));
    std::vector<std::thread> threads;
    for (int rank = 0; rank < size; ++rank)
    {
      threads.emplace_back(
        [&group, &body, rank]
        {
          ThreadCommunicator communicator(group, rank);
          body(communicator);
        });
    }
    for (std::thread& thread : threads)
    {
      thread.join();
    }
  }

  /// Calls body(communicator) in the same way; returns what each rank gives.
  template <typename Body>
  static auto Collect(int size, const Body& body)
  {
    std::vector<std::decay_t<decltype(body(std::declval<Communicator&>()))>> results(
      static_cast<std::size_t>(size));
    Run(size,
      [&](Communicator& ranks)
      { results[static_cast<std::size_t>(ranks.GetRank())] = body(ranks); });
    return results;
  }

  int GetRank() const override { return this->Rank; }
  int GetSize() const override { return static_cast<int>(this->Shared.Slots.size()); }
  int GetRanksOnNode() override { return this->GetSize(); }

  void ReduceMinimum(std::vector<std::uint64_t>& values) override
  {
    this->Reduce(values, [](std::uint64_t a, std::uint64_t b) { return std::min(a, b); });
  }
  void ReduceMaximum(std::vector<std::uint64_t>& values) override
  {
    this->Reduce(values, [](std::uint64_t a, std::uint64_t b) { return std::max(a, b); });
  }
  void ReduceSum(std::vector<std::uint64_t>& values) override
  {
    this->Reduce(values, [](std::uint64_t a, std::uint64_t b) { return a + b; });
  }
  std::vector<Message> AllGather(const Message& mine) override
  {
    std::vector<Message> outgoing;
    std::vector<std::uint64_t> hasMemory = { 1 };
    try
    {
      outgoing.assign(this->Shared.Slots.size(), mine);
    }
    catch (const std::bad_alloc&)
    {
      hasMemory[0] = 0;
    }
    this->ReduceMinimum(hasMemory);
    if (hasMemory[0] == 0)
    {
      throw NoMemoryForMessages();
    }
    return this->Exchange(std::move(outgoing));
  }
  std::vector<Message> Exchange(std::vector<Message> outgoing) override
  {
    this->Shared.Slots[static_cast<std::size_t>(this->Rank)] = std::move(outgoing);
    this->Shared.Wait();
    std::vector<Message> incoming;
    for (std::vector<Message>& slot : this->Shared.Slots)
    {
      incoming.push_back(std::move(slot[static_cast<std::size_t>(this->Rank)]));
    }
    this->Shared.Wait();
    return incoming;
  }

  std::unique_ptr<SharedCounters> MakeCounters(bool wanted) override
  {
    std::vector<std::uint64_t> all = { wanted ? 1U : 0U };
    this->ReduceMinimum(all);
    if (all.front() == 0)
    {
      return nullptr;
    }
    if (this->Rank == 0)
    {
      this->Shared.Counters = std::vector<std::atomic<std::uint64_t>>(this->Shared.Slots.size());
    }
    this->Shared.Wait();
    return std::make_unique<GroupCounters>(this->Shared);
  }

private:
  struct Group
  {
    explicit Group(std::size_t size)
      : Slots(size)
      , Values(size)
    {
    }
    void Wait()
    {
      std::unique_lock<std::mutex> lock(this->Mutex);
      const std::uint64_t round = this->Round;
      if (++this->Arrived == this->Slots.size())
      {
        this->Arrived = 0;
        ++this->Round;
        this->Condition.notify_all();
        return;
      }
      this->Condition.wait(lock, [&] { return this->Round != round; });
    }
    std::mutex Mutex;
    std::condition_variable Condition;
    std::size_t Arrived = 0;
    std::uint64_t Round = 0;
    std::vector<std::vector<Message>> Slots;
    std::vector<std::vector<std::uint64_t>*> Values;
    std::vector<std::atomic<std::uint64_t>> Counters;
  };

  class GroupCounters : public SharedCounters
  {
  public:
    explicit GroupCounters(Group& group)
      : Shared(group)
    {
    }
    Result<std::uint64_t> Add(int rank, std::uint64_t amount) override
    {
      return this->Shared.Counters[static_cast<std::size_t>(rank)].fetch_add(amount);
    }
    Result<std::vector<std::uint64_t>> Read(const std::vector<int>& ranks) override
    {
      std::vector<std::uint64_t> values;
      for (const int rank : ranks)
      {
        values.push_back(this->Shared.Counters[static_cast<std::size_t>(rank)]);
      }
      return values;
    }

  private:
    Group& Shared;
  };

  ThreadCommunicator(Group& group, int rank)
    : Shared(group)
    , Rank(rank)
  {
  }

  template <typename Operation>
  void Reduce(std::vector<std::uint64_t>& values, Operation operation)
  {
    // Without memory of its own, which could be short on one rank.
    this->Shared.Values[static_cast<std::size_t>(this->Rank)] = &values;
    this->Shared.Wait();
    if (this->Rank == 0)
    {
      for (std::size_t rank = 1; rank < this->Shared.Values.size(); ++rank)
      {
        std::transform(values.begin(), values.end(), this->Shared.Values[rank]->begin(),
          values.begin(), operation);
      }
    }
    this->Shared.Wait();
    if (this->Rank != 0)
    {
      std::copy(this->Shared.Values[0]->begin(), this->Shared.Values[0]->end(), values.begin());
    }
    this->Shared.Wait();
  }

  Group& Shared;
  int Rank;
};

} // namespace isosurface

#endif
