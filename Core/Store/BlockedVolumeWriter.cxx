// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolumeWriter.h"

#include "Store/BlockedVolumeWriteJob.h"

namespace isosurface
{

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, SlabSource& source,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  return BlockedVolumeWriteJob(this->Ranks, this->Files, path, source, settings, progress)
    .Run(grid, arrays);
}

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  MemorySource source(piece);
  return this->Write(path, grid, arrays, source, settings, progress);
}

} // namespace isosurface
