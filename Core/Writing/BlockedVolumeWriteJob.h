// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriteJob_h
#define isosurface_BlockedVolumeWriteJob_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Source/SlabSource.h"
#include "Store/BlockedVolumeHeader.h"
#include "Volume/BlockGrid.h"
#include "Writing/BlockExchange.h"
#include "Writing/BlockRangeScan.h"
#include "Writing/BlockStoreWriter.h"
#include "Writing/BlockedVolumeWriter.h"
#include "Writing/RoundPlan.h"
#include "Writing/StoreSpectra.h"

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * One write, step by step. Each step does what this rank can do alone and is followed by an
 * agreement, so that no rank enters a collective operation that another one has given up.
 */
class BlockedVolumeWriteJob
{
public:
  BlockedVolumeWriteJob(Communicator& ranks, FileSystem& files, std::string path,
    SlabSource& source, const BlockedVolumeSettings& settings, Progress progress)
    : Ranks(ranks)
    , Files(files)
    , Path(std::move(path))
    , Source(source)
    , Settings(settings)
    , Tell(std::move(progress))
    , Rank(static_cast<std::size_t>(ranks.GetRank()))
    , Size(static_cast<std::size_t>(ranks.GetSize()))
  {
  }

  /// `pending`: the volume to append to, if it is not the one on disk.
  Result<WriteStatistics> Run(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);

  /// The lock of the volume's folder, on rank 0, is taken by Run() unless it is held already.
  void HoldLock(std::unique_ptr<FolderLock> lock) { this->Lock = std::move(lock); }
  std::unique_ptr<FolderLock> TakeLock() { return std::move(this->Lock); }

  /// What was written, with the time steps before.
  const BlockedVolumeHeader& GetHeader() const { return this->Header; }

private:
  /// The steps of an overview of a volume: Run() but for the generation folder, which is there, and
  /// what makes it visible.
  Status RunOverview(const BlockedVolumeHeader& header, bool hasCoarser);
  Status LockVolume();
  Status WriteVolume(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);
  Status Prepare(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);
  Result<std::optional<BlockedVolumeHeader>> FindVolumeToAppendTo(
    const std::optional<BlockedVolumeHeader>& pending) const;
  Status CheckAppends(const BlockedVolumeHeader& existing) const;
  Status CheckBox() const;
  void PlanLevels();
  Status PrepareBlocks();
  Status CheckEqualArguments();
  Status ShareBoxes();
  Status FindRanges();
  Status MakeGeneration();
  Status CreateStores();
  Status WriteBlocks();
  void FinishBlock(PendingBlock& block, const std::vector<SampleView>& views,
    std::vector<BlockCounters>& counters);
  std::shared_ptr<DecodedBlock> AssembleVariable(
    const PendingBlock& block, std::size_t variable) const;
  Status FinishStores();
  void ShareDescriptions();
  Status ShareSpectra();
  Status WriteOverviews();
  Status WriteOverview(std::size_t overview, std::unique_ptr<BlockedVolumeWriteJob>& coarsest);
  Status RemoveOverviewSamples();
  Status Commit();

  std::uint64_t GetTableBytes() const;
  std::uint64_t GetThreadBytes() const;
  Result<std::uint64_t> GetMemoryLeft(std::uint64_t taken) const;
  Status AgreeOn(const Status& mine);
  /// Runs a step of this rank alone; shortage of memory or threads is an error like others.
  template <typename Step>
  Status Attempt(Step&& step);
  /// Tells the finished share of the work; false if the user asks to stop.
  bool TellShare(double share) const { return !this->Tell || this->Tell(share); }
  Status MakeAborted() const
  {
    return Status(StatusCode::Aborted, this->Path + ": writing was stopped on request");
  }
  bool IsMine(std::uint32_t store) const { return store % this->Size == this->Rank; }
  TimeStepDescription& GetStep() { return this->Header.TimeSteps.back(); }
  /// The folder of this volume's, or overview's, stores.
  std::string GetFolder() { return GetStoresFolder(this->Path) + "/" + this->GetStep().Folder; }

  Communicator& Ranks;
  FileSystem& Files;
  std::string Path;
  SlabSource& Source;
  BlockedVolumeSettings Settings;
  Progress Tell;
  std::size_t Rank;
  std::size_t Size;

  BlockedVolumeHeader Header;
  bool HasCoarser = false; ///< whether an overview is made of this volume, or overview
  BlockGrid Grid;
  ArrayVariables Variables;
  std::vector<ValueType> Types; ///< of the components
  std::optional<BlockExchange> Exchange;
  std::optional<RoundPlan> Plan;
  std::optional<BlockRangeScan> Scan;
  std::vector<std::uint32_t> BlockStores;                 ///< per block
  std::vector<std::unique_ptr<BlockStoreWriter>> Writers; ///< per store; null for another rank's
  std::unique_ptr<WritableFile> OverviewSamples;          ///< null if there is no coarser volume
  std::optional<StoreSpectra> Spectra;
  std::unique_ptr<FolderLock> Lock; ///< of rank 0
  std::string NewFolder;            ///< of rank 0; empty until it is made
  bool IsVisible = false;
  WriteStatistics Statistics;
};

template <typename Step>
Status BlockedVolumeWriteJob::Attempt(Step&& step)
{
  try
  {
    return step();
  }
  catch (const std::exception& exception)
  {
    return Status(
      StatusCode::IoError, this->Path + ": cannot be written here: " + exception.what());
  }
}

} // namespace isosurface

#endif
