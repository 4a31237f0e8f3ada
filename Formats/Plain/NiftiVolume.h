// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NiftiVolume_h
#define isosurface_NiftiVolume_h

#include "Formats/Source/FormatFunctions.h"

#include <string>

namespace isosurface
{

/**
 * A volume in a single file of NIfTI-1 or NIfTI-2, plain or gzip, in either byte order: integers of 8
 * to 64 bits, floats of 32 and 64, with a fourth axis as time steps. The order of the samples is that of
 * the file. The grid is that of the sform if there is one, otherwise of the qform, in millimetres or
 * whatever the file has, x to the right, y to the front and z up; otherwise the spacing alone.
 * Samples with a slope and an intercept are scaled (FindScaledType()).
 *
 * Source: R. W. Cox et al., nifti1.h (2003) and nifti2.h (2011), nifti.nimh.nih.gov.
 */
Result<OpenedVolume> OpenNiftiVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice);

} // namespace isosurface

#endif
