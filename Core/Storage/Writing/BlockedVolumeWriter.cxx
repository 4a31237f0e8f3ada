// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockedVolumeWriter.h"

#include "Storage/Writing/BlockedVolumeWriteJob.h"
#include "Storage/Writing/GenerationFolder.h"

namespace isosurface
{

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, BoxSource& source,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  if (!settings.Append || path != this->PendingPath)
  {
    this->DiscardPending();
  }
  BlockedVolumeWriteJob job(this->Ranks, this->Files, path, source, settings, progress);
  job.HoldLock(std::move(this->PendingLock));
  auto written = job.Run(grid, arrays, this->Pending);
  this->IsPendingKept = job.KeepsJournal();
  if (!written.IsOk())
  {
    this->PendingLock = job.TakeLock();
    this->DiscardPending();
  }
  else if (settings.Publish)
  {
    this->Pending.reset();
  }
  else
  {
    this->PendingPath = path;
    this->Pending = job.GetHeader();
    this->PendingLock = job.TakeLock();
  }
  return written;
}

BlockedVolumeWriter::~BlockedVolumeWriter()
{
  this->DiscardPending();
}

void BlockedVolumeWriter::DiscardPending()
{
  if (this->Pending && !this->IsPendingKept && this->Ranks.GetRank() == 0)
  {
    GenerationFolder::DiscardUnnamed(this->Files, this->PendingPath, *this->Pending);
  }
  this->Pending.reset();
  this->PendingLock.reset();
}

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  MemorySource source(piece);
  return this->Write(path, grid, arrays, source, settings, progress);
}

} // namespace isosurface
