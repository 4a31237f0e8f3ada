// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceRelocation_h
#define isosurface_SourceRelocation_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/VolumeOpener.h"

#include <string>

namespace isosurface
{

/**
 * Names the new place of the source of a volume in place, by a new header. Where time steps have
 * several sources, those with the last name of `source` are meant. `source` is a VolumeName; without
 * a part behind a colon, it keeps the one that it had.
 *
 * If files have other sizes or times than when they were indexed, all samples are read and compared
 * with the checksums of the indexed ones. Errors: InvalidArgument if the volume is not in place, or
 * has no such source; Corrupt if the source is another one. Then the volume stays as it was.
 *
 * Cost: opening the source; perhaps one pass over its samples, by `threads` threads.
 */
Status RelocateSource(FileSystem& files, VolumeOpener opener, const std::string& path,
  const std::string& source, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
