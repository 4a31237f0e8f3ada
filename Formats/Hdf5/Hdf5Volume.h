// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5Volume_h
#define isosurface_Hdf5Volume_h

#include "Formats/Source/FormatFunctions.h"

#include <vector>

namespace isosurface
{

/**
 * A volume in an HDF5 file:
 *
 *     file:/path     the dataset of that path, with 3 to 5 axes (ArrayAxes::Parse), as the file
 *                    describes it (Hdf5Description)
 *     file:/group    image data of VTKHDF, if the group is one
 *     file           image data of VTKHDF in /VTKHDF, the image of Imaris, or else the only dataset
 *                    of numbers with three axes, or the only one with four, or with five; a last axis
 *                    of one sample does not count
 *
 * VTKHDF (the file format of VTK's documentation, version 1 and 2): ImageData alone, with its extent,
 * origin, spacing, direction, point arrays and time steps.
 *
 * Errors: NotFound, with the datasets of the file, if it does not say which one is meant.
 */
extern "C" const FormatFunctions IsosurfaceHdf5Format;

} // namespace isosurface

#endif
