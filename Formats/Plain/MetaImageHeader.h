// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MetaImageHeader_h
#define isosurface_MetaImageHeader_h

#include "Formats/Plain/RawVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <string>

namespace isosurface
{

/**
 * Reads the header of a MetaImage (.mhd, or .mha with the samples in the same file). Supported: two
 * or three dimensions, and more of one sample each; one channel; binary samples in one file
 * (ElementDataFile = LOCAL or a name) or in a file for each slice or slab (LIST, or a pattern with
 * first, last and step), also compressed (CompressedData). Unknown fields are ignored. Errors,
 * which name the field: Unsupported, Corrupt (contradictory).
 *
 * TransformMatrix begins with the direction of the x axis, which becomes the first column of
 * Direction.
 *
 * Source: the MetaIO documentation of Kitware's wiki (MetaIO/Documentation).
 */
Result<RawVolume> ReadMetaImageHeader(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
