// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RawSamples_h
#define isosurface_RawSamples_h

#include "Formats/Source/FormatFunctions.h"
#include "Ground/Base/FileSystem.h"

#include <string>

namespace isosurface
{

/**
 * Files of samples without a header. What they are stands behind the colon of their name:
 *
 *     XxYxZ,TYPE[,big-endian][,header-bytes=N]      512x512x300,uint16,header-bytes=128
 *
 * or, if that is empty, in the name of the file, which then has nothing but these samples:
 * NAME_XxYxZ_TYPE.raw, as the names of the Open SciVis Datasets are. A name with ".gz" behind is of a
 * gzip stream of all that.
 */
extern const FormatFunctions RawSamplesFormat;

/// Whether a text is such a description; not what it says of a file.
bool IsRawDescription(const std::string& text);

} // namespace isosurface

#endif
