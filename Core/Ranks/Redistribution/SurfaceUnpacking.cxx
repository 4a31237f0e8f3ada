// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/SurfaceUnpacking.h"

#include "Ground/Base/WithinMemory.h"
#include "Ranks/Redistribution/BlockPacking.h"

#include <chrono>
#include <utility>

namespace isosurface
{

SurfaceUnpacking::SurfaceUnpacking(const EdgeIndexHeader& header, const ContourRequest& request,
  std::vector<BlockDescription> blocks, int threads)
  : Blocks(std::move(blocks))
  , Thread(
      [this, &header, &request, threads]
      {
        Result<Surface> surface = this->Unpack(header, request, threads);
        const std::lock_guard<std::mutex> lock(this->Mutex);
        this->Outcome = std::move(surface);
        this->Done.notify_all();
      })
{
}

SurfaceUnpacking::~SurfaceUnpacking()
{
  this->Stopped = true;
  this->Blocks.GiveUp();
  this->Thread.join();
}

Result<Surface> SurfaceUnpacking::Unpack(
  const EdgeIndexHeader& header, const ContourRequest& request, int threads)
{
  const auto progress = [this](double share)
  {
    this->Share = share;
    return !this->Stopped;
  };
  return RunWithinMemory("", "There is not enough memory to redistribute the isosurface.",
    [&] { return UnpackBlocks(header, request, this->Blocks, threads, progress); });
}

Result<Surface> SurfaceUnpacking::Finish(const Progress& progress)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  while (!this->Done.wait_for(
    lock, std::chrono::milliseconds(20), [this] { return this->Outcome.has_value(); }))
  {
    if (progress && !progress(this->Share))
    {
      this->Stopped = true;
      return Status(StatusCode::Aborted, "The redistribution was aborted.");
    }
  }
  return std::move(*this->Outcome);
}

} // namespace isosurface
