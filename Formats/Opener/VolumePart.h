// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumePart_h
#define isosurface_VolumePart_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridPlace.h"
#include "Ground/Volume/VertexBox.h"
#include "Ground/Volume/VolumeOpener.h"

#include <array>
#include <memory>
#include <optional>
#include <string>

namespace isosurface
{

/**
 * A part of a volume is a volume, which has its place in the world and its vertices' coordinates from the
 * whole one. Its name is that of the whole one, with "[x0-x1,y0-y1,z0-z1]" behind what is meant within the
 * file: the first and the last vertex on each axis, counted from 0. "brain.zarr:0[0-99,100-199,64-127]"
 */
std::optional<VertexBox> TakePart(std::string& within);

/// The name of the part of a volume that has a box of the world, x0 x1 y0 y1 z0 z1: whole chunks, where rows
/// cannot be read alone. It is the name of the whole volume if that is the part. `place`: what changes the
/// grid of the file. Cost: reading headers. Errors: OpenForeignVolume; InvalidArgument if the box is beside
/// the volume.
Result<std::string> FindPart(FileSystem& files, const std::string& name, const std::string& axes,
  const GridPlace& place, const std::array<double, 6>& bounds);

/// A box of another source, which is within it.
std::unique_ptr<BoxSource> CutSource(std::unique_ptr<BoxSource> source, const VertexBox& part);
/// Leaves that part of a grid.
void CutGrid(GridGeometry& grid, std::optional<GridLines>& lines, const VertexBox& part);

} // namespace isosurface

#endif
