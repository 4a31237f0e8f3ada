// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FinishedBlocks_h
#define isosurface_FinishedBlocks_h

#include "Ground/Volume/ValueKey.h"
#include "Storage/Store/BlockDirectory.h"

#include <map>
#include <string>
#include <vector>

namespace isosurface
{

/// The next blocks of a volume that is being written.
struct FinishedBlocks
{
  /// Ranges[variable][n] is the value range of the n-th next block, on whichever rank it was written.
  std::vector<std::vector<KeyRange>> Ranges;
  /// Of a volume that is not in place: the records of the blocks that this rank has written, by the
  /// folders of their stores.
  std::map<std::string, std::vector<BlockDirectoryEntry>> Records;
};

} // namespace isosurface

#endif
