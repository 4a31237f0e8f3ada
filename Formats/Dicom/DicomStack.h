// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomStack_h
#define isosurface_DicomStack_h

#include "Formats/Dicom/DicomSlice.h"
#include "Formats/Source/FolderFiles.h"
#include "Ground/Volume/VolumeOpener.h"

#include <vector>

namespace isosurface
{

/**
 * Makes a stack of the images of a series: sorts them by their place along the normal of their planes.
 *
 * Scouts are left out: images that say so (LOCALIZER), if others are there, and those of another
 * orientation than most images have. So are copies: images with the samples of another one in its place.
 * Errors name the file: Unsupported if the images are not those of one stack.
 */
Status SortSlices(std::vector<DicomSlice>& slices, PassedOver& over);

/// Sets the grid from slices in their order, which must have equal distances (to a hundredth). Says how
/// far a gantry is tilted.
Status TakeGrid(const std::vector<DicomSlice>& slices, OpenedVolume& volume);

} // namespace isosurface

#endif
