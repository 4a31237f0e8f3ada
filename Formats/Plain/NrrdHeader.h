// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NrrdHeader_h
#define isosurface_NrrdHeader_h

#include "Formats/Plain/RawVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <string>

namespace isosurface
{

/**
 * Reads the header of a NRRD file (.nrrd, or .nhdr with the samples in other files). Supported: two
 * or three axes of space, and any axes of one sample; one value a sample; encoding raw or gzip; one
 * file, or a file for each slice or slab (LIST, or a pattern with first, last and step); skipped
 * lines and bytes. Unknown fields are ignored. Errors, which name the field: Unsupported, Corrupt
 * (contradictory).
 *
 * The spacing is the lengths of the space directions. Coordinates are not converted to another
 * space.
 *
 * Source: the definition of the NRRD file format, teem.sourceforge.net/nrrd/format.html.
 */
Result<RawVolume> ReadNrrdHeader(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
