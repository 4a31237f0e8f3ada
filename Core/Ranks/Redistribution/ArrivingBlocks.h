// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrivingBlocks_h
#define isosurface_ArrivingBlocks_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

namespace isosurface
{

/// What all ranks know of a block before its records travel.
struct BlockDescription
{
  VertexBox Vertices;
  Index3 Lattice{};                  ///< see BlockSource
  std::vector<std::uint64_t> Points; ///< for each isovalue: crossed edges, including shared faces
  std::uint64_t Bytes = 0;           ///< of its records

  std::uint64_t CountPoints() const
  {
    return std::accumulate(this->Points.begin(), this->Points.end(), std::uint64_t{ 0 });
  }
};

/// The error for messages that differ from what was sent.
inline Status MakeDamagedMessage()
{
  return { StatusCode::Corrupt, "A message of isosurface blocks between ranks arrived damaged." };
}

/// The blocks that a rank receives, in the order of ExchangePlan::Incoming. One thread reports each
/// block that has arrived; others wait for the block that they need next.
class ArrivingBlocks
{
public:
  explicit ArrivingBlocks(std::vector<BlockDescription> blocks)
    : Blocks(std::move(blocks))
    , Bytes(Blocks.size(), nullptr)
  {
  }

  const std::vector<BlockDescription>& GetBlocks() const { return this->Blocks; }

  /// The block's bytes, as many as its description says. Waits for them; null after GiveUp.
  const std::uint8_t* Wait(std::size_t block)
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    this->Changed.wait(lock, [&] { return this->Bytes[block] || this->GivenUp; });
    return this->Bytes[block];
  }

  /// Reports that a block has arrived. The bytes must outlive the object.
  void Arrive(std::size_t block, const std::uint8_t* bytes)
  {
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      this->Bytes[block] = bytes;
    }
    this->Changed.notify_all();
  }

  /// Reports that no further block will arrive.
  void GiveUp()
  {
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      this->GivenUp = true;
    }
    this->Changed.notify_all();
  }

private:
  const std::vector<BlockDescription> Blocks;
  std::mutex Mutex;
  std::condition_variable Changed;
  std::vector<const std::uint8_t*> Bytes;
  bool GivenUp = false;
};

} // namespace isosurface

#endif
