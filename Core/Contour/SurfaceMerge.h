// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceMerge_h
#define isosurface_SurfaceMerge_h

#include "Contour/SurfaceExtractor.h"

#include <vector>

namespace isosurface
{

/**
 * One surface of several that were extracted from parts of a grid by requests of the same kind,
 * with GlobalIds. Points of equal global id become one: they are bitwise equal, so the first is
 * kept. The result has its parts by isovalue, then by surface as given. Connectivity has Offsets if
 * all surfaces have them.
 *
 * Cost: one hash table entry a point, and a copy of everything: meant for surfaces that come in
 * pieces anyway, such as those of a composite dataset. ExtractSurface itself shares points already.
 */
Surface MergeSurfaces(const std::vector<Surface>& surfaces);

} // namespace isosurface

#endif
