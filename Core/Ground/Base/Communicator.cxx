// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Communicator.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

const char* NoMemoryForMessages::what() const noexcept
{
  return "a rank has not enough memory for the messages between ranks";
}

void Communicator::Deliver(std::vector<Message> outgoing, std::vector<Message>& incoming,
  const std::function<void(int rank)>& arrived)
{
  incoming = this->Exchange(std::move(outgoing));
  for (std::size_t rank = 0; rank < incoming.size(); ++rank)
  {
    if (!incoming[rank].empty())
    {
      arrived(static_cast<int>(rank));
    }
  }
}

int Communicator::ChooseThreads(int wanted)
{
  const int ranksOnNode = this->GetRanksOnNode();
  return wanted > 0 ? wanted : ChooseThreadCount(ranksOnNode);
}

CommonValue MakeCommonFile(const std::string& path, std::uint64_t fingerprint)
{
  return { fingerprint,
    path +
      ": the ranks see different files under this path, or the same one before and after it was "
      "written; reload it" };
}

namespace
{

// What a rank is told of the errors of all: a code and a reason, or nothing, of each.
Status ChooseError(const Status& mine, const std::vector<Message>& messages)
{
  const auto hasCode = [](const Message& message, StatusCode code)
  { return !message.empty() && static_cast<StatusCode>(message[0]) == code; };
  const auto readReason = [](const Message& message)
  { return std::string(message.begin() + 1, message.end()); };
  // Who stops is not told of errors: if some ranks were, these alone would fail.
  const auto stopped = std::find_if(messages.begin(), messages.end(),
    [&](const Message& message) { return hasCode(message, StatusCode::Aborted); });
  if (stopped != messages.end())
  {
    return Status(StatusCode::Aborted, readReason(*stopped));
  }
  // What follows from another rank's error says less than that one.
  const auto isCause = [&](const Message& message)
  { return !message.empty() && !hasCode(message, StatusCode::RemoteFailure); };
  auto failed = std::find_if(messages.begin(), messages.end(), isCause);
  const bool isKnown = failed != messages.end();
  failed = isKnown ? failed
                   : std::find_if(messages.begin(), messages.end(),
                       [](const Message& message) { return !message.empty(); });
  return mine.IsOk() || (isKnown && mine.GetCode() == StatusCode::RemoteFailure)
    ? Status(StatusCode::RemoteFailure,
        "rank " + std::to_string(failed - messages.begin()) + " failed: " + readReason(*failed))
    : mine;
}

// A code and a reason, or nothing.
Message PackError(const Status& status)
{
  if (status.IsOk())
  {
    return {};
  }
  const std::string reason = status.GetMessage();
  Message message(1 + reason.size(), static_cast<std::uint8_t>(status.GetCode()));
  std::copy(reason.begin(), reason.end(), message.begin() + 1);
  return message;
}

} // namespace

std::uint64_t Communicator::Minimum(std::uint64_t mine)
{
  std::vector<std::uint64_t> values = { mine };
  this->ReduceMinimum(values);
  return values.front();
}

std::uint64_t Communicator::Maximum(std::uint64_t mine)
{
  std::vector<std::uint64_t> values = { mine };
  this->ReduceMaximum(values);
  return values.front();
}

std::uint64_t Communicator::Sum(std::uint64_t mine)
{
  std::vector<std::uint64_t> values = { mine };
  this->ReduceSum(values);
  return values.front();
}

Status Communicator::Agree(const Status& mine)
{
  if (this->GetSize() == 1)
  {
    return mine;
  }
  // Without an error a single cheap reduction suffices; messages travel only if a rank has failed.
  if (this->All(mine.IsOk()))
  {
    return mine;
  }
  return RunCollective(
    "a rank failed", [&] { return ChooseError(mine, this->AllGather(PackError(mine))); });
}

Status Communicator::ReduceAgreed(const Status& mine, std::vector<std::uint64_t>& maxima)
{
  maxima.push_back(mine.IsOk() ? 0 : 1);
  this->ReduceMaximum(maxima);
  const bool areOk = maxima.back() == 0;
  maxima.pop_back();
  return areOk || this->GetSize() == 1 ? mine : this->Agree(mine);
}

Result<std::vector<Message>> Communicator::GatherAgreed(const Status& status, const Message& mine)
{
  std::vector<Message> messages = this->AllGather(status.IsOk() ? mine : PackError(status));
  const auto isError = [](const Message& message) { return message.front() != 0; };
  const bool hasFailed = std::any_of(messages.begin(), messages.end(), isError);
  for (Message& message : messages)
  {
    if (!hasFailed)
    {
      message.erase(message.begin());
    }
    else if (!isError(message))
    {
      message.clear();
    }
  }
  return hasFailed ? Result<std::vector<Message>>(ChooseError(status, messages))
                   : Result<std::vector<Message>>(std::move(messages));
}

Status Communicator::Agree(const Status& mine, const std::vector<CommonValue>& values)
{
  if (this->GetSize() == 1)
  {
    return mine;
  }
  // One reduction for the error and all values: the maximum of ~v is ~minimum of v.
  std::vector<std::uint64_t> reduced{ mine.IsOk() ? 0u : 1u };
  for (const CommonValue& common : values)
  {
    reduced.push_back(common.Value);
    reduced.push_back(~common.Value);
  }
  this->ReduceMaximum(reduced);
  if (reduced[0] != 0)
  {
    return this->Agree(mine);
  }
  for (std::size_t index = 0; index < values.size(); ++index)
  {
    if (reduced[1 + 2 * index] != ~reduced[2 + 2 * index])
    {
      return this->NameDifference(values[index]);
    }
  }
  return mine;
}

Status Communicator::NameDifference(const CommonValue& mine)
{
  Message message;
  AppendLittleEndian(message, mine.Value);
  const std::vector<Message> messages = this->AllGather(message);
  const auto other = std::find_if(messages.begin(), messages.end(),
    [&messages](const Message& any) { return any != messages.front(); });
  return Status(StatusCode::InvalidArgument,
    mine.Difference + " (rank " + std::to_string(other - messages.begin()) +
      " differs from rank 0)");
}

} // namespace isosurface
