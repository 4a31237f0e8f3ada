// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceQueries_h
#define isosurface_SurfaceQueries_h

#include "Formats/Files/VolumeFile.h"

#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Ranks/Query/ContourBlocks.h"
#include "Ranks/Query/SurfaceRequest.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Surface/Contour/Surface.h"

#include <array>
#include <cstddef>
#include <memory>
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

/// Offsets of cells, the width of their corners and the last bits of normals are those of a version of VTK (902 is
/// 9.2). 0: there are no offsets, corners have the fewest bytes, normals are those of 9.4.
void MatchVtk(int version, ContourRequest& request);

/// The isosurfaces; of several ranks this one's part. `warning` names lost stores, whose replicas were read.
/// `level` becomes that of the surface, `islands` what was found of them. Collective with ranks. Cost and errors:
/// StoredField, ChooseIslands, and GetBlocks of the file.
Result<Surface> ExtractSurface(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning,
  int* level = nullptr, ChosenIslands* islands = nullptr);

/// Writes them as an edge-index file. Collective with ranks. Errors: CollectVolumeBlocks, MakeSurfaceHeader,
/// EdgeIndexWriteJob; InvalidArgument if the file is the volume.
Status WriteSurface(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const std::string& path, const BlockCoding& coding,
  const EdgeIndexWriteJob::Settings& settings, const Progress& progress);

/// The vertices of each block that the isosurfaces cross. Cost and errors: PlanQuery; GetBlocks.
Result<std::vector<VertexBox>> FindActiveBlocks(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress, std::string& warning);

/// How many triangles the isosurfaces have in the whole volume. Cost and errors: EstimateTriangles of
/// LevelChoice.h, and GetBlocks of the file.
Result<double> EstimateTriangles(VolumeFile& file, const ContouredSamples& samples,
  const SurfaceRequest& request, const Progress& progress = {});

/// The minimum and the maximum of the finite samples, NaN if there are none. Errors: GetBlocks of the file.
Result<std::array<double, 2>> ReadRange(
  VolumeFile& file, const ContouredSamples& samples, const Progress& progress);

/// Cost and errors: BlockedVolume::GetSpectrum, and GetBlocks of the file.
Result<std::shared_ptr<const WorkloadSpectrum>> ReadSpectrum(
  VolumeFile& file, const ContouredSamples& samples, const Progress& progress);

} // namespace isosurface

#endif
