// SPDX-License-Identifier: BSD-3-Clause
#include "Base/Communicator.h"

#include <algorithm>
#include <string>
#include <utility>

namespace isosurface
{

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

Status Communicator::Agree(const Status& mine)
{
  if (this->GetSize() == 1)
  {
    return mine;
  }
  // Without an error a single cheap reduction suffices; messages travel only if a rank has failed.
  std::vector<std::uint64_t> failed{ mine.IsOk() ? 0u : 1u };
  this->ReduceMaximum(failed);
  if (failed[0] == 0)
  {
    return mine;
  }
  const std::string& text = mine.GetMessage();
  Message message;
  if (!mine.IsOk())
  {
    message.resize(1 + text.size());
    message[0] = static_cast<std::uint8_t>(mine.GetCode());
    std::copy(text.begin(), text.end(), message.begin() + 1);
  }
  const std::vector<Message> messages = this->AllGather(message);
  if (!mine.IsOk())
  {
    return mine;
  }
  for (std::size_t rank = 0; rank < messages.size(); ++rank)
  {
    if (!messages[rank].empty())
    {
      const std::string reason(messages[rank].begin() + 1, messages[rank].end());
      // If the user aborted one rank, the others have not failed.
      return static_cast<StatusCode>(messages[rank][0]) == StatusCode::Aborted
        ? Status(StatusCode::Aborted, reason)
        : Status(StatusCode::RemoteFailure, "rank " + std::to_string(rank) + " failed: " + reason);
    }
  }
  return mine;
}

} // namespace isosurface
