// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrivingBlocks_h
#define isosurface_ArrivingBlocks_h

#include "Ranks/Redistribution/BlockDescription.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

namespace isosurface
{

/// The blocks that a rank receives, in the order of ExchangePlan::Incoming. One thread reports each
/// block that has arrived; others wait for the block that they need next.
class ArrivingBlocks
{
public:
  explicit ArrivingBlocks(std::vector<BlockDescription> blocks);

  const std::vector<BlockDescription>& GetBlocks() const { return this->Blocks; }

  /// The block's bytes, as many as its description says. Waits for them; null after GiveUp.
  const std::uint8_t* Wait(std::size_t block);

  /// Reports that a block has arrived. The bytes must outlive the object.
  void Arrive(std::size_t block, const std::uint8_t* bytes);

  /// Reports that no further block will arrive.
  void GiveUp();

private:
  const std::vector<BlockDescription> Blocks;
  std::mutex Mutex;
  std::condition_variable Changed;
  std::vector<const std::uint8_t*> Bytes;
  bool GivenUp = false;
};

} // namespace isosurface

#endif
