// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffVolume_h
#define isosurface_TiffVolume_h

#include "Formats/Source/FormatFunctions.h"

namespace isosurface
{

/**
 * A volume of TIFF:
 *
 *     file           the first image of the file; the pages are slices, channels and time steps as
 *                    OME-XML, ImageJ or tifffile say in the descriptions, or all of them slices
 *     file:NAME      another image, by its name, identifier or number (from 0)
 *     folder, a*.tif a slice a page of all files (SliceFiles); or, if the first one has OME-XML that
 *                    names others, its first image
 *
 * Channels are arrays, samples of a pixel components. Of a pyramid (tag SubIFDs) it may be a coarser
 * level, whose slices are as far apart as its rows (of a level with half of the rows every second page)
 * unless few would be left.
 */
extern "C" const FormatFunctions IsosurfaceTiffFormat;

} // namespace isosurface

#endif
