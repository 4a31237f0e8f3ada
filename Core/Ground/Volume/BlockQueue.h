// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockQueue_h
#define isosurface_BlockQueue_h

#include "Ground/Base/Status.h"

#include <cstddef>
#include <vector>

namespace isosurface
{

/// Decides during an extraction which blocks of a source belong to it. Only the thread that began
/// the extraction calls these functions.
class BlockQueue
{
public:
  virtual ~BlockQueue() = default;

  /// The numbers in the source of the next blocks, each of which is taken once; none at the end.
  virtual Result<std::vector<std::size_t>> Take() = 0;

  /// About how many blocks there will be.
  virtual std::size_t GetExpectedBlocks() const = 0;

  /// Called now and then between two calls of Take, and after the last one: lets others reach what
  /// this queue shares with them, where that needs this process (SharedCounters).
  virtual void LetOthersIn() {}
};

} // namespace isosurface

#endif
