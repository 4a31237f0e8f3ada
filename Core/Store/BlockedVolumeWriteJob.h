// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriteJob_h
#define isosurface_BlockedVolumeWriteJob_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Source/SlabSource.h"
#include "Store/BlockExchange.h"
#include "Store/BlockRangeScan.h"
#include "Store/BlockStoreWriter.h"
#include "Store/BlockedVolumeHeader.h"
#include "Store/BlockedVolumeWriter.h"
#include "Store/RoundPlan.h"
#include "Store/StoreSpectra.h"
#include "Volume/BlockGrid.h"

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

  Result<WriteStatistics> Run(
    const GridGeometry& grid, const std::vector<ArrayDescription>& arrays);

private:
  /// The steps of an overview of a volume: Run() but for the generation folder, which is there, and
  /// what makes it visible. `ranges`: of the volume's finite values, so that all spectra have the
  /// same bins.
  Status RunOverview(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::string& folder, const std::vector<KeyRange>& ranges);
  Status Prepare(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays);
  Status CheckBox() const;
  Status CheckEqualArguments();
  Status ShareBoxes();
  Status FindRanges();
  Status MakeGeneration();
  Status CreateStores();
  Status WriteBlocks();
  void FinishBlock(PendingBlock& block, std::vector<BlockCounters>& counters);
  Status FinishStores();
  void ShareDescriptions();
  Status ShareSpectra();
  Status WriteOverviews();
  Status WriteOverview(std::unique_ptr<BlockedVolumeWriteJob>& coarsest);
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
  TimeStepDescription& GetStep() { return this->Header.TimeSteps[0]; }
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
  BlockGrid Grid;
  std::vector<ValueType> Types;
  std::optional<BlockExchange> Exchange;
  std::optional<RoundPlan> Plan;
  std::optional<BlockRangeScan> Scan;
  std::vector<std::uint32_t> BlockStores;                 ///< per block
  std::vector<std::unique_ptr<BlockStoreWriter>> Writers; ///< per store; null for another rank's
  std::unique_ptr<WritableFile> OverviewSamples;          ///< null if there is no coarser volume
  std::optional<StoreSpectra> Spectra;
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
