// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_DiskFaults_h
#define isosurface_Testing_DiskFaults_h

#include <cstdint>
#include <string>

namespace isosurface
{

/**
 * Faults of the operating system below Core's local file system: this program's calls of open,
 * pread, pwrite, fsync, flock, rename and mkdir for files in one folder are counted, and one of them, or
 * all from one on, do something else than they should. Any thread may call them meanwhile.
 */
class DiskFaults
{
public:
  enum class Kind
  {
    None,
    Fail,        ///< this call returns an error
    FailFromNow, ///< this call and all later ones of its sort do: the disk is full
    Interrupt,   ///< this call returns EINTR; the next one works
    Short,       ///< a read or write does half of what it is asked
    Stale,       ///< from this read on, its descriptor fails with ESTALE: a server was started anew
    Flip,        ///< this read returns another byte in the middle
    NoLocks,     ///< all locks fail with ENOLCK
    Kill,        ///< the process ends before the call
    Tear         ///< the process ends in the middle of a write
  };

  /// Counts and disturbs calls for files below a folder.
  static void Watch(const std::string& folder);
  /// The call number `operation`, from 0, has a fault. EMFILE is only one of open.
  static void Arm(Kind kind, int error, std::uint64_t operation);
  static void Disarm() { Arm(Kind::None, 0, 0); }
  /// Calls since the last Arm().
  static std::uint64_t GetOperations();
  /// Whether the fault has happened.
  static bool HasHappened();
};

} // namespace isosurface

#endif
