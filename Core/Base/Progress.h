// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Progress_h
#define isosurface_Progress_h

#include <functional>

namespace isosurface
{

/**
 * Told the finished share of the work (0 to 1) now and then; answers false to stop it. Called from
 * the calling thread only. An empty function means that nobody wants to know.
 */
using Progress = std::function<bool(double share)>;

/// What tells `progress`, which must outlive it, of a part of its work, from `begin` to `end`.
inline Progress MakePartOfProgress(const Progress& progress, double begin, double end)
{
  if (!progress)
  {
    return {};
  }
  return [&progress, begin, end](double share) { return progress(begin + share * (end - begin)); };
}

} // namespace isosurface

#endif
