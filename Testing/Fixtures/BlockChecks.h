// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockChecks_h
#define isosurface_BlockChecks_h

#include "vtkSmartPointer.h"

#include <gtest/gtest.h>

#include <vector>

class vtkBlockedVolumeReader;
class vtkImageData;
class vtkPartitionedDataSet;

namespace isosurface
{

/// What is compared: blocks that a reader gave, and the image that was written.
struct BlockChecks
{
  vtkImageData* Image; ///< the whole volume
  int Level = 0;       ///< every 2^Level-th vertex is there

  /// Every vertex of every block has the value and place of the image's vertex.
  testing::AssertionResult HaveValues(
    const std::vector<vtkPartitionedDataSet*>& pieces, const char* array) const;

  /// Every cell of the level's grid is in one block not a ghost; a vertex is a ghost if all cells
  /// at it are. Blocks without vtkGhostType have no ghosts.
  testing::AssertionResult HaveEachCellOnce(
    const std::vector<vtkPartitionedDataSet*>& pieces) const;
};

/// One piece of several as the reader gives it to a consumer that knows nothing of blocked volumes.
vtkSmartPointer<vtkPartitionedDataSet> ReadPiece(
  vtkBlockedVolumeReader* reader, int piece, int pieces);

} // namespace isosurface

#endif
