// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/RoundWriting.h"

#include <utility>

namespace isosurface
{

RoundWriting::RoundWriting(std::vector<PendingBlock> blocks, Write write, RecordBuffers& records,
  std::shared_ptr<RoundWriting> before)
  : Blocks(std::move(blocks))
  , WriteBlock(std::move(write))
  , Records(records)
  , Finished(Blocks.size(), false)
  , Outcome(std::async(std::launch::async,
      [this, before = std::move(before)]() mutable
      {
        const std::shared_ptr<RoundWriting> held = std::move(before);
        return this->WriteAll(held.get());
      }))
{
}

RoundWriting::~RoundWriting()
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->IsStopped = true;
  }
  this->Changed.notify_all();
  this->Outcome.wait();
}

void RoundWriting::MarkFinished(std::size_t index)
{
  bool isWanted = false;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Finished[index] = true;
    isWanted = index == this->Wanted;
  }
  if (isWanted)
  {
    this->Changed.notify_all();
  }
}

/// Waits until a block is finished. Returns false if there is nothing to wait for any longer.
bool RoundWriting::WaitFor(std::size_t index)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  this->Wanted = index;
  this->Changed.wait(lock, [&] { return this->IsStopped || this->Finished[index]; });
  return !this->IsStopped;
}

Status RoundWriting::WriteAll(RoundWriting* before)
{
  const auto write = [&]() -> Status
  {
    if (before)
    {
      ISOSURFACE_RETURN_IF_ERROR(before->Wait());
    }
    for (std::size_t index = 0; index < this->Blocks.size(); ++index)
    {
      if (!this->WaitFor(index))
      {
        return Status(StatusCode::Aborted, "writing was given up");
      }
      PendingBlock& block = this->Blocks[index];
      ISOSURFACE_RETURN_IF_ERROR(this->WriteBlock(block));
      this->Records.Return(std::move(block.Record));
    }
    return Status::Ok();
  };
  return Attempt("a round of blocks cannot be written", write);
}

} // namespace isosurface
