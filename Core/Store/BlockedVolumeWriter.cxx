// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolumeWriter.h"

#include "Store/BlockedVolumeWriteJob.h"

namespace isosurface
{

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  return BlockedVolumeWriteJob(this->Ranks, this->Files, path, piece, settings, progress)
    .Run(grid, arrays);
}

} // namespace isosurface
