// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeQuery_h
#define isosurface_VolumeQuery_h

#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <string>

namespace isosurface
{

/// The seconds of a steady clock.
double GetSeconds();

/// The cost of an isosurface of a blocked volume, from opening the file on.
struct VolumeQuery
{
  double Seconds = 0;
  double OpenSeconds = 0; ///< of them, to open the file
  QueryStatistics Statistics;
  std::size_t Triangles = 0;
};

/// Extracts an isosurface of the first array, the piece of one of several ranks, with an empty block
/// cache. Ends the program with a message if the volume cannot be read.
VolumeQuery MeasurePiece(
  const std::string& path, double isovalue, int rank, int ranks, int threads);

/// Drops a folder's files from the page cache, so that they are read from the disk.
void DropFromPageCache(const std::string& folder);

/// Removes a volume and its stores.
void RemoveVolume(const std::string& path);

} // namespace isosurface

#endif
