// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeQuery_h
#define isosurface_VolumeQuery_h

#include "Store/QueryStatistics.h"

#include <cstddef>
#include <string>

namespace isosurface
{

/// Seconds on a clock that never goes back.
double GetSeconds();

/// What one isosurface of a blocked volume took, from opening the file on.
struct VolumeQuery
{
  double Seconds = 0;
  QueryStatistics Statistics;
  std::size_t Triangles = 0;
};

/**
 * Extracts an isosurface of the first array with an empty block cache, `repeats` times; returns the
 * run of median time. `cold`: the stores are dropped from the page cache before each run. Ends the
 * program with a message if the volume cannot be read.
 */
VolumeQuery MeasureQuery(
  const std::string& path, double isovalue, int threads, int repeats, bool cold);

/// The same, once, for the share of one of several ranks.
VolumeQuery MeasureShare(
  const std::string& path, double isovalue, int rank, int ranks, int threads);

/// Makes the next readings of a folder's files come from the disk.
void DropFromPageCache(const std::string& folder);

/// Removes a volume and its stores.
void RemoveVolume(const std::string& path);

} // namespace isosurface

#endif
