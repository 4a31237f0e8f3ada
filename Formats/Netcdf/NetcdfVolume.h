// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NetcdfVolume_h
#define isosurface_NetcdfVolume_h

#include "Formats/Source/FormatFunctions.h"

#include <vector>

namespace isosurface
{

/**
 * A variable of three or four axes in a NetCDF file: "file.nc:variable", "file.nc:group/variable", or
 * "file.nc" if there is only one. What the axes are is found by the CF conventions: the attributes axis,
 * standard_name and units of the coordinates; without them, the order is z, y, x, with t before. The
 * coordinates of z, y and x have equal steps, or ascend and make a rectilinear grid; those of equal
 * steps that descend reverse a direction. Times are the coordinates of t. Samples with scale_factor
 * and add_offset are scaled, to the type of these attributes.
 *
 * Source: "NetCDF Climate and Forecast (CF) Metadata Conventions" 1.10, sections 4, 5 and 8.1.
 */
extern "C" const FormatFunctions IsosurfaceNetcdfFormat;

} // namespace isosurface

#endif
