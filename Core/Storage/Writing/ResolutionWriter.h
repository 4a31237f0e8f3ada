// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ResolutionWriter_h
#define isosurface_ResolutionWriter_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BoxSource.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Writing/BlockCounts.h"
#include "Storage/Writing/BlockExchange.h"
#include "Storage/Writing/BlockRangeScan.h"
#include "Storage/Writing/BlockRounds.h"
#include "Storage/Writing/OverviewSamples.h"
#include "Storage/Writing/WriteContext.h"
#include "Storage/Writing/WriteJournal.h"
#include "Storage/Writing/WrittenStores.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Writes the stores and spectra of one grid, the volume's or an overview's, with all ranks. Call
/// the collective functions in their order; the time step needs a folder before Write().
class ResolutionWriter
{
public:
  /// `header`: its last time step is written. An overview's has the ranges of the volume, so that
  /// all spectra have the same bins. `hasCoarser`: whether an overview is made of this grid, so
  /// that its samples are kept. The references must outlive this object.
  ResolutionWriter(const WriteContext& context, BoxSource& source,
    const BlockedVolumeHeader& header, bool hasCoarser, Progress progress);

  /// Makes Write() go on where a journal says, and keep it at checkpoints, with the settings'
  /// seconds between them. The journal must outlive this object.
  void KeepJournal(WriteJournal& journal) { this->Journal = &journal; }
  /// Makes Write() tell what is read and which blocks are finished (BlockedVolumeSettings).
  void TellCaller() { this->TellsCaller = true; }

  /// Collective. Plans who sends which samples; fails if the ranks do not have all of them.
  Status Prepare();
  /// Collective. Distributes the blocks over the stores. Reads the source only where their ranges
  /// decide.
  Status Distribute();
  /// Collective. Writes the stores and the spectra.
  Status Write();

  /// The header with the time step as far as it is written.
  const BlockedVolumeHeader& GetHeader() const { return this->Header; }
  TimeStepDescription& GetStep() { return this->Header.TimeSteps.back(); }
  /// The folder of the stores.
  std::string GetFolder() const;
  /// Equal on all ranks, and complete after Write().
  const WriteStatistics& GetStatistics() const { return this->Statistics; }

  /// After Write(), the samples of the next overview. Frees what else is held of this grid.
  std::unique_ptr<OverviewSource> MakeOverviewSource();
  /// Collective. Removes the files of these samples, and those of the stores' journals.
  Status RemoveTemporaryFiles();

private:
  using Clock = std::chrono::steady_clock;

  std::vector<VertexBox> GatherBoxes() const;
  bool TellsFinished() const { return this->TellsCaller && this->Context.Settings.WhenFinished; }
  bool NeedsRanges() const;
  Status ScanRanges(BlockRangeScan& scan);
  Status OpenStores();
  Status WriteBlocks();
  bool IsCheckpointDue(std::int64_t blocks, bool isStopping);
  Status MakeCheckpoint(std::int64_t blocks);
  void FinishBlock(PendingBlock& block, const std::vector<SampleView>& views, int thread);
  Status TellBlocks(std::int64_t blocks);
  void ShareRanges();
  Status FinishStores();
  Status ShareDescriptions();
  Status ShareSpectra();

  std::uint64_t GetTableBytes() const;
  std::uint64_t GetThreadBytes() const;
  Result<std::uint64_t> GetMemoryLeft(std::uint64_t taken) const;
  /// Reports the finished share of the work; false if the user asks to stop.
  bool TellShare(double share) const { return !this->Tell || this->Tell(share); }

  const WriteContext& Context;
  BoxSource& Source;
  Progress Tell;
  BlockedVolumeHeader Header;
  bool HasCoarser;
  BlockGrid Grid;
  ArrayVariables Variables;
  std::vector<ValueType> Types; ///< of the components
  std::optional<BlockExchange> Exchange;
  std::optional<RoundPlan> Plan;
  std::vector<std::uint32_t> BlockStores; ///< per block
  std::optional<BlockCounts> Counts;      ///< during Write()
  std::optional<WrittenStores> Stores;    ///< from Write() on
  WriteJournal* Journal = nullptr;
  bool TellsCaller = false;
  std::int64_t ToldBlocks = 0;      ///< how many blocks were told to be finished
  Clock::time_point Begin;          ///< of Write()
  Clock::time_point LastCheckpoint; ///< or Begin
  WriteStatistics Statistics;
};

} // namespace isosurface

#endif
