// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ProgressiveLevels_h
#define isosurface_ProgressiveLevels_h

#include "Ground/Base/Status.h"
#include "Ranks/Query/LevelChoice.h"
#include "Storage/Store/BlockedVolume.h"

namespace isosurface
{

/// The maximum number of triangles of the first surface of a progressive extraction, relative to
/// the final one.
constexpr double FirstSurfaceShare = 1.0 / 20;

/// The maximum number of triangles of the first surface: two cores without a graphics card extract
/// and draw this number in about a tenth of a second.
constexpr double FirstSurfaceTriangles = 100'000;

/**
 * Finds the level that a progressive extraction begins with: the finest one coarser than `finest`
 * whose surface has at most FirstSurfaceShare of the triangles at `finest`, and at most
 * FirstSurfaceTriangles, by EstimateTriangles.
 * If no level is as coarse, or the surface is estimated to vanish there, it is the coarsest level
 * with triangles; `finest` itself if there is none coarser, or if it has no triangles.
 *
 * Errors: those of EstimateTriangles. Cost: the spectra of the volume and its overviews, which the
 * volume keeps.
 */
Result<int> FindFirstLevel(BlockedVolume& volume, const SurfaceQuery& query, int finest);

/// Up to this number of triangles, no intermediate level is shown between the first surface and the
/// final one. The samples of an index in place may have to be decompressed, which takes longer.
constexpr double DirectSurfaceTriangles = 20'000'000;
constexpr double DirectSurfaceTrianglesInPlace = 10'000'000;

/// Whether the surface at `finest` has at most DirectSurfaceTriangles, or DirectSurfaceTrianglesInPlace, by
/// EstimateTriangles. Errors: those of EstimateTriangles.
Result<bool> IsDirectSurface(BlockedVolume& volume, const SurfaceQuery& query, int finest);

/// The level that follows `level`, which is coarser than `finest`: the finest one, but not finer
/// than `finest`, that is stored in the same blocks as the next finer level. Coarser levels there
/// would read as many blocks for a fraction of the triangles.
int GetNextLevel(const BlockedVolume& volume, int level, int finest);

} // namespace isosurface

#endif
