// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IsovalueJoin_h
#define isosurface_IsovalueJoin_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockSource.h"

#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The surface of decoded blocks: of each isovalue those of its own source, joined to what
 * ExtractSurface makes of several isovalues.
 *
 * sources: as many as the header has isovalues; null for one that is left out. Isovalues and
 * Attributes of the request are not used: the surface has all attributes of the header. Normals are
 * there if they are asked for and are among them; otherwise asking for them is an InvalidArgument,
 * since a surface by itself has no gradients.
 *
 * Errors: Corrupt (blocks that do not fit each other), InvalidArgument, OutOfMemory, Aborted, what
 * Acquire returns.
 */
Result<Surface> JoinIsovalues(const EdgeIndexHeader& header,
  const std::vector<std::unique_ptr<BlockSource>>& sources, const ContourRequest& request,
  int threads, const Progress& progress);

} // namespace isosurface

#endif
