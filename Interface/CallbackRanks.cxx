// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/CallbackRanks.h"

#include "Ground/Base/Checksum.h"
#include "Interface/Call.h"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include <unistd.h>

namespace isosurface
{

Status CallbackRanks::Check(const si_ranks* ranks)
{
  if (!ranks)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(ranks, "si_ranks"));
  return taken.count > 0 && taken.rank >= 0 && taken.rank < taken.count && taken.all_gather &&
      taken.exchange
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument, "si_ranks: there is no such rank, or a callback is NULL");
}

std::unique_ptr<Communicator> CallbackRanks::Make(const si_ranks* ranks)
{
  if (!ranks || ranks->count == 1)
  {
    return std::make_unique<SerialCommunicator>();
  }
  return std::make_unique<CallbackRanks>(*TakeStructure(ranks, "si_ranks"));
}

std::vector<std::uint64_t> CallbackRanks::Gather(const std::vector<std::uint64_t>& mine)
{
  std::vector<std::uint64_t> all;
  const std::size_t count = mine.size() * static_cast<std::size_t>(this->GetSize());
  all.resize(count);
  const std::size_t bytes = mine.size() * sizeof(mine[0]);
  if (bytes > 0 && this->Given.all_gather(this->Given.context, mine.data(), all.data(), bytes) != 0)
  {
    throw std::runtime_error("the program's all_gather has failed");
  }
  return all;
}

int CallbackRanks::GetRanksOnNode()
{
  char name[256] = {};
  ::gethostname(name, sizeof(name) - 1);
  const std::uint64_t mine = ComputeChecksum(name, sizeof(name));
  const std::vector<std::uint64_t> all = this->Gather({ mine });
  return static_cast<int>(std::count(all.begin(), all.end(), mine));
}

void CallbackRanks::Reduce(std::vector<std::uint64_t>& values, Operation operation)
{
  std::vector<std::uint64_t> all;
  const std::uint64_t bytes =
    values.size() * sizeof(values[0]) * static_cast<std::uint64_t>(this->GetSize());
  this->AllocateTogether(bytes, [&] { all.reserve(bytes / sizeof(values[0])); });
  all = this->Gather(values);
  for (std::size_t index = 0; index < all.size(); ++index)
  {
    std::uint64_t& value = values[index % values.size()];
    value = index < values.size() ? all[index] : operation(value, all[index]);
  }
}

void CallbackRanks::ReduceMinimum(std::vector<std::uint64_t>& values)
{
  this->Reduce(values, [](std::uint64_t a, std::uint64_t b) { return std::min(a, b); });
}

void CallbackRanks::ReduceMaximum(std::vector<std::uint64_t>& values)
{
  this->Reduce(values, [](std::uint64_t a, std::uint64_t b) { return std::max(a, b); });
}

void CallbackRanks::ReduceSum(std::vector<std::uint64_t>& values)
{
  this->Reduce(values, [](std::uint64_t a, std::uint64_t b) { return a + b; });
}

void CallbackRanks::AllocateTogether(std::uint64_t largest, const std::function<void()>& allocate)
{
  constexpr std::uint64_t agreedBytes = 1024; // below, another message costs more than it is worth
  std::uint64_t lacks = 0;
  try
  {
    allocate();
  }
  catch (const std::bad_alloc&)
  {
    if (largest < agreedBytes)
    {
      throw;
    }
    lacks = 1;
  }
  if (largest >= agreedBytes)
  {
    const std::vector<std::uint64_t> all = this->Gather({ lacks });
    if (std::any_of(all.begin(), all.end(), [](std::uint64_t one) { return one != 0; }))
    {
      throw NoMemoryForMessages();
    }
  }
}

std::vector<Message> CallbackRanks::AllGather(const Message& mine)
{
  return this->Exchange(std::vector<Message>(static_cast<std::size_t>(this->GetSize()), mine));
}

std::vector<Message> CallbackRanks::Exchange(std::vector<Message> outgoing)
{
  const auto ranks = static_cast<std::size_t>(this->GetSize());
  const auto me = static_cast<std::size_t>(this->GetRank());
  std::vector<Message> incoming(ranks);
  incoming[me] = std::move(outgoing[me]);
  outgoing[me].clear();
  std::vector<std::uint64_t> sizes(ranks);
  std::transform(outgoing.begin(), outgoing.end(), sizes.begin(),
    [](const Message& message) { return message.size(); });
  // Row r has what rank r sends.
  const std::vector<std::uint64_t> table = this->Gather(sizes);
  std::uint64_t largest = 0;
  for (std::size_t receiver = 0; receiver < ranks; ++receiver)
  {
    std::uint64_t received = 0;
    for (std::size_t rank = 0; rank < ranks; ++rank)
    {
      received += table[rank * ranks + receiver];
    }
    largest = std::max(largest, received);
  }
  this->AllocateTogether(largest,
    [&]
    {
      for (std::size_t rank = 0; rank < ranks; ++rank)
      {
        if (rank != me)
        {
          incoming[rank].resize(table[rank * ranks + me]);
        }
      }
    });
  std::vector<const void*> from(ranks);
  std::vector<void*> to(ranks);
  std::vector<std::size_t> incomingSizes(ranks);
  for (std::size_t rank = 0; rank < ranks; ++rank)
  {
    from[rank] = outgoing[rank].data();
    to[rank] = incoming[rank].data();
    incomingSizes[rank] = rank == me ? 0 : incoming[rank].size();
  }
  if (this->Given.exchange(
        this->Given.context, from.data(), sizes.data(), to.data(), incomingSizes.data()) != 0)
  {
    throw std::runtime_error("the program's exchange has failed");
  }
  return incoming;
}

} // namespace isosurface
