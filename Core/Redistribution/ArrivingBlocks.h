// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrivingBlocks_h
#define isosurface_ArrivingBlocks_h

#include "Redistribution/BlockDescription.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

namespace isosurface
{

/**
 * The blocks that a rank is to get, by place: one thread tells of each that is there, others wait
 * for the one that they need next.
 */
class ArrivingBlocks
{
public:
  explicit ArrivingBlocks(std::vector<BlockDescription> blocks);

  const std::vector<BlockDescription>& GetBlocks() const { return this->Blocks; }

  /// The block's bytes, of the size of its description; waits for them. Null if there will be none.
  const std::uint8_t* Wait(std::size_t block);

  /// The block's bytes are there; they must outlive all waiting.
  void Arrive(std::size_t block, const std::uint8_t* bytes);

  /// No further block will come.
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
