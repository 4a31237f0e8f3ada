// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourHeader_h
#define isosurface_ContourHeader_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "ContourBlocks.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "SurfacePolyData.h"

#include <functional>
#include <vector>

namespace isosurface
{

/// What an edge-index stream of these blocks says of them; its settings are left as they are. The errors are
/// the maximum ones of a value of the arrays, and of a component of the normals.
EdgeIndexHeader DescribeContourBlocks(
  const ContourBlocks& blocks, double arrayError, double normalError);

/// What `describe` gives on the first rank that has samples, which others do not know all of.
/// Collective. Errors of any rank: InvalidArgument (see EdgeIndexHeader::Check), OutOfMemory.
Result<EdgeIndexHeader> ShareHeader(
  Communicator& ranks, bool hasSamples, const std::function<EdgeIndexHeader()>& describe);

/// The interpolated arrays, which ranks without samples do not know. Collective. Error of any rank:
/// OutOfMemory.
Result<std::vector<InterpolatedArray>> ShareArrays(
  Communicator& ranks, const ContourBlocks& blocks);

} // namespace isosurface

#endif
