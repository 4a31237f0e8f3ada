// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceQueries_h
#define isosurface_SurfaceQueries_h

#include "Formats/Files/VolumeFile.h"

#include "Ranks/Islands/IslandChoice.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Surface/Contour/Surface.h"

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Which samples of a volume an isosurface is of. All must be those of the volume.
struct ContouredSamples
{
  std::size_t Array = 0;
  int Component = 0; ///< or Variable::Magnitude
  std::size_t TimeStep = 0;
  int Level = 0;
};

/// Which isosurfaces, and where.
struct SurfaceRequest
{
  std::vector<double> Isovalues;
  std::optional<std::array<double, 6>> Bounds; ///< Region::FromBounds; nothing: everywhere
  bool Normals = false;
  PointPrecision Precision = PointPrecision::Default;
  GridSides ClosedSides;
  bool DropDegenerateTriangles = false;
  std::optional<IslandRequest> Islands; ///< nothing: all
  std::vector<std::size_t> Attributes;  ///< arrays to interpolate
  int Threads = 1;
};

/// The isosurfaces. `warning` names lost stores, whose replicas were read. Cost and errors:
/// ExtractLevel, ChooseIslands, and GetBlocks of the file.
Result<Surface> ExtractSurface(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning);

/// The vertices of each block that the isosurfaces cross. Cost and errors: PlanQuery; GetBlocks.
Result<std::vector<VertexBox>> FindActiveBlocks(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning);

/// How many triangles the isosurfaces have in the whole volume. Cost and errors: EstimateTriangles of
/// LevelChoice.h, and GetBlocks of the file.
Result<double> EstimateTriangles(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress = {});

/// Cost and errors: BlockedVolume::GetSpectrum, and GetBlocks of the file.
Result<std::shared_ptr<const WorkloadSpectrum>> ReadSpectrum(
  VolumeFile& file, const ContouredSamples& samples, const Progress& progress);

} // namespace isosurface

#endif
