// SPDX-License-Identifier: BSD-3-Clause
#include "ControllerCommunicator.h"

#include "WindowCounters.h"

#include <vtkCommunicator.h>
#include <vtkMultiProcessController.h>
#include <vtksys/SystemInformation.hxx>
#if __has_include(<vtkMPIController.h>)
#  include <vtkMPICommunicator.h>
#  include <vtkMPIController.h>
#  define ISOSURFACE_HAS_MPI_CONTROLLER
#endif

#include <algorithm>
#include <array>
#include <chrono>
#include <list>
#include <new>
#include <numeric>
#include <string>
#include <thread>
#include <utility>

namespace isosurface
{
namespace
{
constexpr int ExchangeTag = 48211;

// Calls function(pointer, length) for parts of a message that fit one MPI call each.
template <typename Pointer, typename Function>
void ForEachPart(Pointer data, std::size_t size, std::size_t part, const Function& function)
{
  for (std::size_t offset = 0; offset < size; offset += part)
  {
    function(data + offset, static_cast<int>(std::min(part, size - offset)));
  }
}

#ifdef ISOSURFACE_HAS_MPI_CONTROLLER
// Messages from, or to, all other ranks that are under way.
class PendingMessages
{
public:
  explicit PendingMessages(int ranks)
    : Requests(ranks)
  {
  }
  vtkMPICommunicator::Request& Add(int rank)
  {
    this->Left += this->Requests[rank].empty() ? 1 : 0;
    return this->Requests[rank].emplace_back();
  }
  int GetLeft() const { return this->Left; }

  // Calls done(rank) for each rank whose message is complete since the last call. Returns whether
  // there was any.
  bool Test(const std::function<void(int rank)>& done)
  {
    const int before = this->Left;
    for (std::size_t rank = 0; rank < this->Requests.size(); ++rank)
    {
      std::list<vtkMPICommunicator::Request>& parts = this->Requests[rank];
      const bool isPending = !parts.empty();
      parts.remove_if([](vtkMPICommunicator::Request& part) { return part.Test() != 0; });
      if (isPending && parts.empty())
      {
        --this->Left;
        done(static_cast<int>(rank));
      }
    }
    return this->Left < before;
  }

private:
  std::vector<std::list<vtkMPICommunicator::Request>> Requests; ///< by rank
  int Left = 0;
};
#endif
} // namespace

ControllerCommunicator::ControllerCommunicator(
  vtkMultiProcessController* controller, std::size_t largestPart)
  : Controller(controller)
  , PartBytes(std::min(std::max<std::size_t>(largestPart, 1), LargestPart))
{
}

int ControllerCommunicator::GetRank() const
{
  return this->Controller ? this->Controller->GetLocalProcessId() : 0;
}

int ControllerCommunicator::GetSize() const
{
  return this->Controller ? this->Controller->GetNumberOfProcesses() : 1;
}

int ControllerCommunicator::GetRanksOnNode()
{
  if (this->GetSize() == 1)
  {
    return 1;
  }
  vtksys::SystemInformation information;
  const char* name = information.GetHostname();
  const std::string host = name ? name : "";
  const Message mine(host.begin(), host.end());
  const std::vector<Message> hosts = this->AllGather(mine);
  return static_cast<int>(std::count(hosts.begin(), hosts.end(), mine));
}

template <typename Allocate>
void ControllerCommunicator::AllocateTogether(std::size_t largest, const Allocate& allocate)
{
  if (largest < AgreedBytes)
  {
    allocate();
    return;
  }
  int isAllocated = 1;
  try
  {
    allocate();
  }
  catch (const std::bad_alloc&)
  {
    isAllocated = 0;
  }
  int areAllocated = 0;
  this->Controller->AllReduce(&isAllocated, &areAllocated, 1, vtkCommunicator::MIN_OP);
  if (areAllocated == 0)
  {
    throw NoMemoryForMessages();
  }
}

void ControllerCommunicator::Reduce(std::vector<std::uint64_t>& values, int operation)
{
  if (this->GetSize() == 1 || values.empty())
  {
    return;
  }
  std::vector<unsigned long long> mine;
  std::vector<unsigned long long> all;
  this->AllocateTogether(values.size() * sizeof(values[0]),
    [&]
    {
      mine.assign(values.begin(), values.end());
      all.resize(values.size());
    });
  this->Controller->AllReduce(
    mine.data(), all.data(), static_cast<vtkIdType>(mine.size()), operation);
  std::copy(all.begin(), all.end(), values.begin());
}

void ControllerCommunicator::ReduceMinimum(std::vector<std::uint64_t>& values)
{
  this->Reduce(values, vtkCommunicator::MIN_OP);
}

void ControllerCommunicator::ReduceMaximum(std::vector<std::uint64_t>& values)
{
  this->Reduce(values, vtkCommunicator::MAX_OP);
}

void ControllerCommunicator::ReduceSum(std::vector<std::uint64_t>& values)
{
  this->Reduce(values, vtkCommunicator::SUM_OP);
}

void ControllerCommunicator::GatherPart(const Message& mine, std::size_t offset, std::size_t part,
  const std::vector<vtkIdType>& lengths, std::uint8_t* all, std::vector<Message>& messages)
{
  std::vector<vtkIdType> sizes(lengths.size());
  std::vector<vtkIdType> offsets(lengths.size());
  vtkIdType total = 0;
  for (std::size_t rank = 0; rank < lengths.size(); ++rank)
  {
    const auto length = static_cast<std::size_t>(lengths[rank]);
    sizes[rank] = static_cast<vtkIdType>(length > offset ? std::min(part, length - offset) : 0);
    offsets[rank] = total;
    total += sizes[rank];
  }
  const auto own = static_cast<std::size_t>(this->GetRank());
  this->Controller->AllGatherV(
    mine.data() + std::min(offset, mine.size()), all, sizes[own], sizes.data(), offsets.data());
  for (std::size_t rank = 0; rank < lengths.size(); ++rank)
  {
    const std::uint8_t* begin = all + offsets[rank];
    messages[rank].insert(messages[rank].end(), begin, begin + sizes[rank]);
  }
}

std::vector<Message> ControllerCommunicator::AllGather(const Message& mine)
{
  const int ranks = this->GetSize();
  if (ranks == 1)
  {
    return { mine };
  }
  const auto length = static_cast<vtkIdType>(mine.size());
  std::vector<vtkIdType> lengths(ranks);
  this->Controller->AllGather(&length, lengths.data(), 1);
  // The parts of all ranks arrive in one array, whose places MPI counts in int, too.
  const std::size_t part =
    std::max<std::size_t>(this->PartBytes / static_cast<std::size_t>(ranks), 1);
  const auto largest = static_cast<std::size_t>(*std::max_element(lengths.begin(), lengths.end()));
  const auto total =
    static_cast<std::size_t>(std::accumulate(lengths.begin(), lengths.end(), vtkIdType{ 0 }));
  std::vector<Message> messages(ranks);
  std::array<std::uint8_t, FewBytes> few;
  Message many;
  const bool areFew = total <= FewBytes;
  this->AllocateTogether(areFew ? largest : total,
    [&]
    {
      for (int rank = 0; rank < ranks; ++rank)
      {
        messages[rank].reserve(static_cast<std::size_t>(lengths[rank]));
      }
      many.resize(areFew ? 0 : std::min(total, part * static_cast<std::size_t>(ranks)));
    });
  for (std::size_t offset = 0; offset < largest; offset += part)
  {
    this->GatherPart(mine, offset, part, lengths, areFew ? few.data() : many.data(), messages);
  }
  return messages;
}

void ControllerCommunicator::Send(const Message& message, int rank)
{
  ForEachPart(message.data(), message.size(), this->PartBytes,
    [&](const std::uint8_t* part, int size)
    { this->Controller->Send(part, size, rank, ExchangeTag); });
}

void ControllerCommunicator::Receive(Message& message, int rank)
{
  ForEachPart(message.data(), message.size(), this->PartBytes,
    [&](std::uint8_t* part, int size)
    { this->Controller->Receive(part, size, rank, ExchangeTag); });
}

void ControllerCommunicator::PrepareIncoming(
  const std::vector<Message>& outgoing, std::vector<Message>& incoming)
{
  const int ranks = this->GetSize();
  const int me = this->GetRank();
  // Row r of the table holds the lengths that rank r sends.
  std::vector<vtkIdType> lengths(ranks);
  for (int rank = 0; rank < ranks; ++rank)
  {
    lengths[rank] = rank == me ? 0 : static_cast<vtkIdType>(outgoing[rank].size());
  }
  std::vector<vtkIdType> table(static_cast<std::size_t>(ranks) * ranks);
  this->Controller->AllGather(lengths.data(), table.data(), ranks);
  std::size_t largest = 0;
  for (int receiver = 0; receiver < ranks; ++receiver)
  {
    std::size_t received = 0;
    for (int rank = 0; rank < ranks; ++rank)
    {
      received +=
        static_cast<std::size_t>(table[static_cast<std::size_t>(rank) * ranks + receiver]);
    }
    largest = std::max(largest, received);
  }
  this->AllocateTogether(largest,
    [&]
    {
      for (int rank = 0; rank < ranks; ++rank)
      {
        if (rank != me)
        {
          incoming[rank].resize(table[static_cast<std::size_t>(rank) * ranks + me]);
        }
      }
    });
}

bool ControllerCommunicator::ExchangeWithoutBlocking(
  const std::vector<Message>& outgoing, std::vector<Message>& incoming)
{
#ifdef ISOSURFACE_HAS_MPI_CONTROLLER
  if (auto* mpi = vtkMPIController::SafeDownCast(this->Controller))
  {
    const int ranks = this->GetSize();
    const int me = this->GetRank();
    std::vector<vtkMPICommunicator::Request> requests;
    for (int step = 1; step < ranks; ++step)
    {
      const int rank = (me + step) % ranks;
      ForEachPart(outgoing[rank].data(), outgoing[rank].size(), this->PartBytes,
        [&](const std::uint8_t* part, int size)
        {
          requests.emplace_back();
          mpi->NoBlockSend(part, size, rank, ExchangeTag, requests.back());
        });
    }
    for (int step = 1; step < ranks; ++step)
    {
      const int rank = (me + ranks - step) % ranks;
      this->Receive(incoming[rank], rank);
    }
    if (!requests.empty())
    {
      mpi->WaitAll(static_cast<int>(requests.size()), requests.data());
    }
    return true;
  }
#endif
  static_cast<void>(outgoing);
  static_cast<void>(incoming);
  return false;
}

std::vector<Message> ControllerCommunicator::Exchange(std::vector<Message> outgoing)
{
  const int ranks = this->GetSize();
  const int me = this->GetRank();
  std::vector<Message> incoming(ranks);
  incoming[me] = std::move(outgoing[me]);
  if (ranks == 1)
  {
    return incoming;
  }
  this->PrepareIncoming(outgoing, incoming);
  if (this->ExchangeWithoutBlocking(outgoing, incoming))
  {
    return incoming;
  }
  for (int low = 0; low < ranks; ++low)
  {
    for (int high = low + 1; high < ranks; ++high)
    {
      if (me == low)
      {
        this->Send(outgoing[high], high);
        this->Receive(incoming[high], high);
      }
      else if (me == high)
      {
        this->Receive(incoming[low], low);
        this->Send(outgoing[low], low);
      }
    }
  }
  return incoming;
}

std::unique_ptr<SharedCounters> ControllerCommunicator::MakeCounters(bool wanted)
{
  return MakeWindowCounters(this->Controller, wanted);
}

void ControllerCommunicator::Deliver(std::vector<Message> outgoing, std::vector<Message>& incoming,
  const std::function<void(int rank)>& arrived)
{
#ifdef ISOSURFACE_HAS_MPI_CONTROLLER
  auto* mpi = vtkMPIController::SafeDownCast(this->Controller);
  if (mpi && this->GetSize() > 1)
  {
    const int ranks = this->GetSize();
    const int me = this->GetRank();
    PendingMessages receiving(ranks);
    PendingMessages sending(ranks);
    for (int step = 1; step < ranks; ++step)
    {
      const int from = (me + ranks - step) % ranks;
      ForEachPart(incoming[from].data(), incoming[from].size(), this->PartBytes,
        [&](std::uint8_t* part, int size)
        { mpi->NoBlockReceive(part, size, from, ExchangeTag, receiving.Add(from)); });
    }
    for (int step = 1; step < ranks; ++step)
    {
      const int to = (me + step) % ranks;
      ForEachPart(outgoing[to].data(), outgoing[to].size(), this->PartBytes,
        [&](const std::uint8_t* part, int size)
        { mpi->NoBlockSend(part, size, to, ExchangeTag, sending.Add(to)); });
    }
    incoming[me] = std::move(outgoing[me]);
    if (!incoming[me].empty())
    {
      arrived(me);
    }
    while (receiving.GetLeft() + sending.GetLeft() > 0)
    {
      const bool isProgress = receiving.Test(arrived);
      if (!sending.Test([](int) {}) && !isProgress)
      {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    }
    return;
  }
#endif
  this->Communicator::Deliver(std::move(outgoing), incoming, arrived);
}

} // namespace isosurface
