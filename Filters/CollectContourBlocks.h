// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CollectContourBlocks_h
#define isosurface_CollectContourBlocks_h

#include "IsosurfaceFiltersModule.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/ContourBlocks.h"

#include <functional>
#include <optional>

class vtkAlgorithm;
class vtkObject;
class vtkStabbingContour;

namespace isosurface
{

/**
 * What the filter would contour for one of several pieces, block by block. Brings the filter's
 * input up to date for that piece, at that time if one is given; neither makes nor changes the
 * filter's output. Isovalues, region, arrays and level are those of the filter's properties;
 * `blocks` says whether normals and attributes are wanted. Collective.
 *
 * Of a blocked volume the blocks are those of Level, or of the finest coarser level that keeps to
 * MaximumTriangles as far as the contour spectrum can tell. TimeBudget and Progressive have no
 * effect, nor have the options that say what becomes of the blocks: DropDegenerateTriangles and
 * GenerateTriangles.
 *
 * Errors, on all ranks: an input that failed; those of the filter itself.
 */
ISOSURFACEFILTERS_EXPORT Status CollectContourBlocks(vtkStabbingContour* contour, int piece,
  int pieces, const std::optional<double>& time, ContourBlocks& blocks);

/**
 * Runs a step that collects blocks and reads them, and once more where it failed since stores were
 * lost or damaged meanwhile, as RunWithReplicas does. Rank 0 warns of such stores, as `reader`, if
 * all ends well. `step(blocks)` gets new blocks each time. Collective if the step is.
 */
ISOSURFACEFILTERS_EXPORT Status RunWithContourBlocks(
  vtkAlgorithm* reader, Communicator& ranks, const std::function<Status(ContourBlocks&)>& step);

/// The profile for a number that a script or state of any version may have. Warns as `consumer` if there is
/// none of that number.
ISOSURFACEFILTERS_EXPORT int ChooseProfile(vtkObject* consumer, int number);

} // namespace isosurface

#endif
