// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NrrdHeader_h
#define isosurface_NrrdHeader_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Source/RawVolume.h"

#include <string>

namespace isosurface
{

/**
 * Reads the header of a NRRD file (.nrrd, or .nhdr with the samples in files of their own): two or
 * three axes of space, beside any axes of one sample, one value a sample, encoding raw or gzip, in
 * one file or in one file a slice or slab (LIST, or a pattern with first, last and step), behind
 * lines and bytes that are skipped. What it does not know it passes over; what it cannot read is
 * Unsupported, what is contradictory Corrupt, by name.
 *
 * The lengths of the space directions are the spacing; coordinates stay in the file's own space.
 *
 * Source: the definition of the NRRD file format, teem.sourceforge.net/nrrd/format.html.
 */
Result<RawVolume> ReadNrrdHeader(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
