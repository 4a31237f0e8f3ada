// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/ArrivingBlocks.h"

#include <utility>

namespace isosurface
{

ArrivingBlocks::ArrivingBlocks(std::vector<BlockDescription> blocks)
  : Blocks(std::move(blocks))
  , Bytes(Blocks.size(), nullptr)
{
}

const std::uint8_t* ArrivingBlocks::Wait(std::size_t block)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  this->Changed.wait(lock, [&] { return this->Bytes[block] || this->GivenUp; });
  return this->Bytes[block];
}

void ArrivingBlocks::Arrive(std::size_t block, const std::uint8_t* bytes)
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Bytes[block] = bytes;
  }
  this->Changed.notify_all();
}

void ArrivingBlocks::GiveUp()
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->GivenUp = true;
  }
  this->Changed.notify_all();
}

} // namespace isosurface
