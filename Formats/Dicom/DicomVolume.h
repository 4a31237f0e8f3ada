// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomVolume_h
#define isosurface_DicomVolume_h

#include "Formats/Source/FormatFunctions.h"

#include <vector>

namespace isosurface
{

/**
 * A series of DICOM images with a slice a file:
 *
 *     file           the series of this file, in its folder
 *     folder         the only series in the folder or else in its folders; those without a readable image
 *                    do not count; DICOMDIR stands for its folder
 *     pattern        the only series of the files that fit
 *     folder:NAME    the series of this name (DicomSeries.h) or instance UID, or of the only UID that ends so
 *
 * DicomSeries.h and DicomStack.h tell which files are taken. The grid is that of the patient: millimetres, x to the left, y to the back, z up. A tilted
 * gantry gives directions that are not at right angles, and is named in LeftOut. Slope and intercept
 * are applied; the type is the smallest integer that has all values if both are whole numbers,
 * otherwise float32.
 *
 * Source: DICOM PS3.3, C.7.6.2 (Image Plane) and C.11.1 (Modality LUT).
 */
extern "C" const FormatFunctions IsosurfaceDicomFormat;

} // namespace isosurface

#endif
