// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MrcVolume_h
#define isosurface_MrcVolume_h

#include "Formats/Source/FormatFunctions.h"

namespace isosurface
{

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

} // namespace isosurface

#endif
