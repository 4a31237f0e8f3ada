// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceHandle_h
#define isosurface_SurfaceHandle_h

#include "Interface/VolumeHandle.h"

#include "Formats/Files/SurfaceQueries.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// What is asked for, and of which samples.
struct TakenRequest
{
  ContouredSamples Samples;
  SurfaceRequest Surfaces;
  std::vector<std::string> Names; ///< of attributes
};

/// All but the samples and the attributes, which are those of a volume or of images.
Result<TakenRequest> TakeRequest(const si_surface_request& taken, Call& call);

/// A surface as C sees it.
struct OwnedSurface : si_surface
{
  /// `names`: of the attributes.
  OwnedSurface(Surface surface, bool hasNormals, bool hasGlobalIds, std::vector<std::string> names,
    int chosen, ChosenIslands found = {});

  Surface Owned;
  const std::vector<std::string> Names;
  const Buffer<std::int64_t> Islands; ///< of the triangles
  std::vector<si_islands> Counts;
  std::vector<double> Isovalues;
  std::vector<std::int64_t> FirstPoints;
  std::vector<std::int64_t> FirstTriangles;
  std::vector<si_values> Values;
  std::vector<std::int32_t> OfPoints; ///< the block of each point
  std::vector<std::vector<std::int64_t>> Paths;
  std::vector<si_path> Blocks;
};

} // namespace isosurface

#endif
