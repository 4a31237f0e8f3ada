// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/Call.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/ReadingStop.h"

#include <atomic>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include <pthread.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

/// The ranks of a C program. A callback that fails is a std::runtime_error.
class CallbackRanks : public Communicator
{
public:
  /// InvalidArgument if they make no sense. Null: this process alone.
  static Status Check(const si_ranks* ranks);
  /// Ranks that were checked; they are copied.
  static std::unique_ptr<Communicator> Make(const si_ranks* ranks);

  explicit CallbackRanks(const si_ranks& ranks)
    : Given(ranks)
  {
  }

  int GetRank() const override { return this->Given.rank; }
  int GetSize() const override { return this->Given.count; }
  int GetRanksOnNode() override;
  void ReduceMinimum(std::vector<std::uint64_t>& values) override;
  void ReduceMaximum(std::vector<std::uint64_t>& values) override;
  void ReduceSum(std::vector<std::uint64_t>& values) override;
  std::vector<Message> AllGather(const Message& mine) override;
  std::vector<Message> Exchange(std::vector<Message> outgoing) override;

private:
  using Operation = std::uint64_t (*)(std::uint64_t a, std::uint64_t b);

  /// The values of all ranks, which have as many, one rank after the other.
  std::vector<std::uint64_t> Gather(const std::vector<std::uint64_t>& mine);
  void Reduce(std::vector<std::uint64_t>& values, Operation operation);
  /// Allocates memory, of which some rank needs `largest` bytes, the same number on all: on all ranks, or on none.
  void AllocateTogether(std::uint64_t largest, const std::function<void()>& allocate);

  const si_ranks Given;
};

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

constexpr std::chrono::milliseconds TimeBetweenLooks{ 100 };

std::atomic<int> Workers{ 0 }; ///< calls at work
std::atomic<bool> IsForkedAtWork{ false };

/// Has a process that is forked while a thread is at work refuse work, since what that thread held it holds for ever.
const int ForksAreWatched =
  ::pthread_atfork(nullptr, nullptr, [] { IsForkedAtWork = Workers > 0; });

/// The message of the last error of the calling thread.
std::string& GetMessage()
{
  static thread_local std::string message;
  return message;
}

struct Worker
{
  Worker() { ++Workers; }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() { --Workers; }
};

Status RunHere(
  const std::string& context, const si_run* run, const std::function<Status(Call&)>& work)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(run, "si_run"));
  ISOSURFACE_RETURN_IF_ERROR(CallbackRanks::Check(taken.ranks));
  const Worker counted;
  Call call(taken);
  const ReadingStop stop(call.GetProgress());
  Status status = Attempt(context, [&] { return work(call); });
  return status.IsOk() && call.IsStopped()
    ? Status(StatusCode::Aborted, context + ": a callback has stopped it")
    : status;
}

} // namespace

Call::Call(const si_run& run)
  : Run(run)
  , Ranks(CallbackRanks::Make(run.ranks))
  , Advance([this](double done) { return this->Look(done); })
{
}

bool Call::Look(double done)
{
  const auto now = std::chrono::steady_clock::now();
  if (this->Run.progress && !this->Stopped && now - this->LastLook >= TimeBetweenLooks)
  {
    this->LastLook = now;
    this->Stopped = this->Run.progress(done, this->Run.context) != 0;
  }
  return !this->Stopped;
}

void Call::Warn(const std::string& message)
{
  if (this->Run.warn && !this->Stopped && !message.empty())
  {
    this->Stopped = this->Run.warn(message.c_str(), this->Run.context) != 0;
  }
}

si_result EndCall(const Status& status)
{
  if (!status.IsOk())
  {
    GetMessage() = status.GetMessage();
  }
  return static_cast<si_result>(status.GetCode());
}

si_result RunCall(
  const std::string& context, const si_run* run, const std::function<Status(Call&)>& work)
{
  static_cast<void>(ForksAreWatched);
  if (IsForkedAtWork)
  {
    GetMessage() =
      "this process was forked while another thread read or wrote; start processes by 'spawn', or "
      "before there are threads";
    return SI_FORKED;
  }
  return EndCall(Attempt(context, [&] { return RunHere(context, run, work); }));
}

} // namespace isosurface

static_assert(static_cast<int>(isosurface::StatusCode::RemoteFailure) == SI_REMOTE_FAILURE &&
  static_cast<int>(isosurface::StatusCode::Corrupt) == SI_CORRUPT);

int32_t si_version(void)
{
  return SI_VERSION;
}

const char* si_error(void)
{
  return isosurface::GetMessage().c_str();
}
