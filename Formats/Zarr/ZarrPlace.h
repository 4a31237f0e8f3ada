// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrPlace_h
#define isosurface_ZarrPlace_h

#include "Formats/Source/StoredArray.h"
#include "Formats/Zarr/ZarrMetadata.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/GridGeometry.h"

#include <nlohmann/json.hpp>

#include <array>
#include <string>

namespace isosurface
{

/// Where the samples of an array lie on x, y and z. Units are as the file names them; perhaps empty.
struct ZarrPlace
{
  std::array<double, 3> Spacing{ 1, 1, 1 };
  std::array<double, 3> Origin{ 0, 0, 0 };
  std::array<std::string, 3> Units;
};

/// "transform" of COSEM (OpenOrganelle): scale, translate and units of the axes that it names. False if
/// it is none.
bool TakeTransform(const nlohmann::json& transform, ZarrPlace& place);

/**
 * What the attributes of an array and of the two groups around it tell of its place: pixelResolution, a
 * list or { dimensions, unit }; resolution (or voxel_size) and units; downsamplingFactors of a level, or
 * a list of them for the levels s0, s1 ... in a group (also "scales"); offset. A resolution is that of
 * the full size, unless a level has another one than its group or s0. The first sample of a
 * level lies in the middle of those that it stands for.
 *
 * Sources: saalfeldlab/n5-viewer, n5-universe and bigdataviewer-core; the attributes of OpenOrganelle.
 */
ZarrPlace FindZarrPlace(
  FileSystem& files, const std::string& folder, const ZarrNode& node, const ArrayAxes& arrayAxes);

/**
 * Takes the coordinates of xarray (or of netCDF in Zarr): arrays of one axis beside the array, which have
 * the names of its axes x, y and z. Those of equal steps, to a thousandth, give spacing and origin;
 * descending ones reverse a direction. Others are told in `told`. `names`: of x, y and z, perhaps empty.
 */
void TakeCoordinates(FileSystem& files, const std::string& folder,
  const std::array<std::string, 3>& names, GridGeometry& grid, std::string& told);
/// Takes the coordinates of the time axis of that name, if they are one for each step.
void TakeTimes(FileSystem& files, const std::string& folder, const std::string& name,
  std::vector<double>& times, std::string& told);

} // namespace isosurface

#endif
