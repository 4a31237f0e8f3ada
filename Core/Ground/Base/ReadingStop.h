// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ReadingStop_h
#define isosurface_ReadingStop_h

#include "Ground/Base/Progress.h"

namespace isosurface
{

/// While it lives, reads of the calling thread from files of the local file system are Aborted when
/// `progress`, which they call with 0, returns false. So work stops that decodes much of a file before it can
/// tell its progress, as a gzip stream that is read from its end.
class ReadingStop
{
public:
  /// `progress` must outlive this object.
  explicit ReadingStop(const Progress& progress)
    : Before(Current)
  {
    Current = &progress;
  }
  ReadingStop(const ReadingStop&) = delete;
  ReadingStop& operator=(const ReadingStop&) = delete;
  ~ReadingStop() { Current = this->Before; }

  static bool IsWanted() { return Current && *Current && !(*Current)(0); }

private:
  static thread_local const Progress* Current;
  const Progress* Before;
};

} // namespace isosurface

#endif
