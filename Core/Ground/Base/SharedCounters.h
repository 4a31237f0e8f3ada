// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SharedCounters_h
#define isosurface_SharedCounters_h

#include "Ground/Base/Status.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * A counter for each rank, 0 at first, that any rank raises and reads at any time while the others
 * work: no rank waits for another one. Made by Communicator::MakeCounters. All functions are for
 * the thread that made it. Every rank can reach the counter of a rank that has destroyed this
 * object, as long as it has its own one; over some networks not before that rank enters a collective.
 */
class SharedCounters
{
public:
  SharedCounters() = default;
  SharedCounters(const SharedCounters&) = delete;
  SharedCounters& operator=(const SharedCounters&) = delete;
  virtual ~SharedCounters() = default;

  /// Adds to the counter of a rank, as one step that nothing can come between. Returns the value
  /// before. Errors: IoError.
  virtual Result<std::uint64_t> Add(int rank, std::uint64_t amount) = 0;

  /// The values of the counters of some ranks, in their order. Errors: IoError.
  virtual Result<std::vector<std::uint64_t>> Read(const std::vector<int>& ranks) = 0;

  /// To be called now and then during long work: lets others reach this rank's counter where the
  /// network needs this process for that.
  virtual void LetOthersIn() {}
};

} // namespace isosurface

#endif
