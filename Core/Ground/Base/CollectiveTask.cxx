// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/CollectiveTask.h"

#include <utility>

namespace isosurface
{

CollectiveTask::CollectiveTask(Communicator& ranks, std::string context, Work work)
  : Relay(ranks.GetSize() > 1 ? std::make_unique<RelayedCommunicator>(ranks) : nullptr)
  , Task(std::make_unique<BackgroundTask>(std::move(context),
      [relay = this->Relay.get(), work = std::move(work)](const Progress& advance)
      {
        SerialCommunicator alone;
        return work(relay ? static_cast<Communicator&>(*relay) : alone, advance);
      }))
{
}

CollectiveTask::~CollectiveTask()
{
  this->Stop();
  if (this->Relay)
  {
    this->Relay->Close();
  }
}

Status CollectiveTask::Finish(Communicator& ranks, const Progress& progress)
{
  constexpr double pollSeconds = 0.02;
  while (!this->Advance(ranks, pollSeconds))
  {
    if (ranks.Any(progress && !progress(this->GetProgress())))
    {
      return { StatusCode::Aborted, "The work was stopped." };
    }
  }
  return this->GetStatus();
}

bool CollectiveTask::Advance(Communicator& ranks, double seconds)
{
  return this->Relay ? this->Relay->Serve(ranks, seconds, [this] { return this->HasEnded(); })
                     : this->Task->Wait(seconds);
}

} // namespace isosurface
