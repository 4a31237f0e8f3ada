// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeWriteJob_h
#define isosurface_BlockedVolumeWriteJob_h

#include "Base/Communicator.h"
#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Partition/BlockWorkload.h"
#include "Partition/WorkloadSpectrum.h"
#include "Store/BlockExchange.h"
#include "Store/BlockRangeScan.h"
#include "Store/BlockStoreWriter.h"
#include "Store/BlockedVolumeHeader.h"
#include "Store/BlockedVolumeWriter.h"
#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
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
    const VolumePiece& piece, const BlockedVolumeSettings& settings, Progress progress)
    : Ranks(ranks)
    , Files(files)
    , Path(std::move(path))
    , Piece(piece)
    , Settings(settings)
    , Tell(std::move(progress))
    , Rank(static_cast<std::size_t>(ranks.GetRank()))
    , Size(static_cast<std::size_t>(ranks.GetSize()))
  {
  }

  Result<WriteStatistics> Run(
    const GridGeometry& grid, const std::vector<ArrayDescription>& arrays);

private:
  struct Spectra
  {
    std::vector<WorkloadSpectrum> Arrays;
    std::mutex Mutex;
  };

  /// Blocks [Begin, End), in the order of their indices; the same on all ranks.
  struct Round
  {
    std::int64_t Begin = 0;
    std::int64_t End = 0;
    std::uint64_t Bytes = 0;        ///< of their records
    std::vector<PendingBlock> Mine; ///< those that this rank writes
    std::vector<Message> Messages;
  };

  Status Prepare(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays);
  Status CheckPiece() const;
  Status CheckEqualArguments();
  Status ShareBoxes();
  Status FindRanges();
  Status MakeGeneration();
  Status CreateStores();
  Status WriteBlocks();
  Status PackRound(const BlockExchange& exchange, Round& round) const;
  Status FinishRound(std::vector<PendingBlock>& blocks);
  void FinishBlock(PendingBlock& block, std::vector<BlockWorkload>& counters);
  Status FinishStores();
  void ShareDescriptions();
  Status ShareSpectra();
  Status Commit();

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
  std::size_t GetWriter(std::uint32_t store) const { return store % this->Size; }
  TimeStepDescription& GetStep() { return this->Header.TimeSteps[0]; }

  Communicator& Ranks;
  FileSystem& Files;
  std::string Path;
  const VolumePiece& Piece;
  BlockedVolumeSettings Settings;
  Progress Tell;
  std::size_t Rank;
  std::size_t Size;

  BlockedVolumeHeader Header;
  BlockGrid Grid;
  std::vector<ValueType> Types;
  std::vector<VertexBox> Boxes; ///< of all ranks
  std::vector<VertexBox> Owned;
  BlockRangeScan Scan;
  std::vector<std::uint32_t> BlockStores;                 ///< per block
  std::vector<std::unique_ptr<BlockStoreWriter>> Writers; ///< per store; null for another rank's
  std::vector<std::unique_ptr<Spectra>> StoreSpectra;     ///< likewise
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
