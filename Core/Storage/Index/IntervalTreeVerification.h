// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalTreeVerification_h
#define isosurface_IntervalTreeVerification_h

#include "Storage/Index/IntervalTreeFormat.h"

namespace isosurface
{

/**
 * Checks that an external interval tree answers every query as its intervals demand: each interval
 * is in all the lists of a node that it has to be in, in their order, and nowhere else; the bounds
 * by which queries leave out lists, subtrees or the whole tree are those of the intervals there
 * (Documentation/formats/interval-tree.md). Matching checksums do not show that: a program may have
 * written them over a wrong bound.
 *
 * Corrupt, naming file, page and reason, at the first fault. Cost: reads each page once. Memory: the intervals of the largest node.
 */
Status VerifyIntervalTree(
  const PagedFileReader& file, const IntervalTreeHeader& header, PageStatistics& statistics);

} // namespace isosurface

#endif
