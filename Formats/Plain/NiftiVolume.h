// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NiftiVolume_h
#define isosurface_NiftiVolume_h

#include "Formats/Source/FormatFunctions.h"

#include <string>

namespace isosurface
{

/**
 * A volume of NIfTI-1 or NIfTI-2, in a single file or in a pair .hdr and .img, plain or gzip, in either
 * byte order: integers of 8 to 64 bits, floats of 32 and 64, with a fourth axis as time steps. The order of the samples is that of
 * the file. The grid is that of the sform if there is one that is not all zeros, otherwise of the
 * qform, x to the right, y to the front and z up; otherwise the spacing alone.
 * Samples with a slope and an intercept are scaled (FindScaledType()).
 *
 * Source: R. W. Cox et al., nifti1.h (2003) and nifti2.h (2011), nifti.nimh.nih.gov.
 */
Result<OpenedVolume> OpenNiftiVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice);

/// The header of a pair, of the name of either file.
std::string FindNiftiHeader(const std::string& path);

} // namespace isosurface

#endif
