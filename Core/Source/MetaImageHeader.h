// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MetaImageHeader_h
#define isosurface_MetaImageHeader_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Source/RawVolume.h"

#include <string>

namespace isosurface
{

/**
 * Reads the header of a MetaImage (.mhd, or .mha with the samples in the same file): two or three
 * dimensions (further ones of one sample each), one channel, binary samples in one file
 * (ElementDataFile = LOCAL or a name) or in one file a slice or slab (LIST, or a pattern with
 * first, last and step), as they are or compressed as a whole (CompressedData). What it does not
 * know it passes over; what it cannot read is Unsupported, what is contradictory Corrupt, by name.
 *
 * TransformMatrix has the direction of the x axis first; it becomes the first column of Direction.
 *
 * Source: the MetaIO documentation of Kitware's wiki (MetaIO/Documentation).
 */
Result<RawVolume> ReadMetaImageHeader(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
