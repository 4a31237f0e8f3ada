// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AllocationCounter_h
#define isosurface_AllocationCounter_h

#include <cstddef>

namespace isosurface
{

/**
 * Counts the bytes that operator new has given out, in all of the test program: an oracle for byte
 * budgets that knows nothing of who keeps them.
 */
class AllocationCounter
{
public:
  /// Begins anew: what is allocated now counts as nothing.
  static void Reset();
  /// The most bytes at a time since Reset().
  static std::size_t GetPeak();
};

} // namespace isosurface

#endif
