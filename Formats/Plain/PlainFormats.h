// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PlainFormats_h
#define isosurface_PlainFormats_h

#include "Formats/Source/FormatFunctions.h"

#include <string>

namespace isosurface
{

/// Opens a volume whose header RawVolume::ReadHeader() reads.
Result<OpenedVolume> OpenRawVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice);

/**
 * A volume of MRC2014 or CCP4, plain or gzip, in either byte order: modes 0 (int8, or uint8 if IMOD
 * says so), 1 (int16), 2 (float32), 6 (uint16) and 12 (float16, read as float32). The axes are brought to
 * x, y and z, whatever the columns, rows and sections are. The spacing is that of the cell, the
 * directions those of its angles; the origin is the field of that name, or else the first sample's place in
 * the cell. A stack of volumes becomes time steps, numbered from 0.
 *
 * Source: A. Cheng et al., "MRC2014", J. Struct. Biol. 192 (2015), www.ccpem.ac.uk/mrc_format.
 */
Result<OpenedVolume> OpenMrcVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice);

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
