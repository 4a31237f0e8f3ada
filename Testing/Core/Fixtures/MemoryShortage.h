// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_MemoryShortage_h
#define isosurface_Testing_MemoryShortage_h

namespace isosurface
{

/// Smaller allocations are so many that only large ones matter in practice.
constexpr unsigned LargeBytes = 1024;

/**
 * While it lasts, one of the large allocations that this process makes, or the calling thread alone,
 * fails: those of operator new, and, with glibc and without sanitizers, those of malloc by this
 * project. One at a time.
 */
class MemoryShortage
{
public:
  enum class Of
  {
    Process,
    Thread
  };

  /// `allocation`: the number of the one that fails, from 0; below 0: none.
  explicit MemoryShortage(long allocation, Of whom = Of::Process);
  ~MemoryShortage();
  MemoryShortage(const MemoryShortage&) = delete;
  MemoryShortage& operator=(const MemoryShortage&) = delete;

  /// The allocations since the last one began. One has failed if they are more than its number.
  static long Count();
};

} // namespace isosurface

#endif
