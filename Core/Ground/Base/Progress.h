// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Progress_h
#define isosurface_Progress_h

#include <functional>

namespace isosurface
{

/**
 * Called now and then with the finished fraction of the work (0 to 1); returns false to stop the
 * work. Only the calling thread calls it. May be empty.
 */
using Progress = std::function<bool(double fraction)>;

/// The progress of one step of the work, which takes the fractions from `begin` to `end` of
/// `progress`. That must outlive the result.
inline Progress MakePartOfProgress(const Progress& progress, double begin, double end)
{
  if (!progress)
  {
    return {};
  }
  return [&progress, begin, end](double fraction)
  { return progress(begin + fraction * (end - begin)); };
}

} // namespace isosurface

#endif
