// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GrowingIndex_h
#define isosurface_GrowingIndex_h

#include "Formats/Indexing/SampleCollector.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Indexing/SourceSample.h"
#include "Ground/Base/BackgroundTask.h"
#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/MemoryFileSystem.h"
#include "Ground/Base/Status.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace isosurface
{

class BlockedVolume;
class FinishedLayers;

/**
 * An index that is written beside the calling thread, and a sample of the source that is shown until
 * then. The index is that of WriteSourceIndex, bit for bit. Its threads have a low priority. Where
 * there are several ranks, they work only while all of them are in Advance(): the calling threads
 * communicate for them.
 *
 * One rank keeps an index that it cannot write to its place in memory, if it is smaller than that of
 * writing it may be.
 *
 * Where there is a sample, surfaces can be extracted of what is indexed (GetFinished), and of boxes before that. If
 * the sample is a coarse one of all of an address, a finer one is fetched first, as fine as some seconds allow.
 * If the budget is far too small for the volume, boxes alone are read until it is raised, or the end is waited for.
 *
 * The destructor stops the writing. Then an older index stays as it was, and what is written of this
 * one is kept for the next try (WriteSourceIndex).
 */
class GrowingIndex
{
public:
  /// Begins to write. Collective.
  GrowingIndex(Communicator& ranks, FileSystem& files, SourceIndex index, SourceSample sample,
    std::uint64_t memoryBytes);

  const SourceIndex& GetIndex() const { return this->Index; }
  const SourceSample& GetSample() const { return this->Sample; }
  /// Shows a sample of another time step, of all ranks.
  void SetSample(SourceSample sample);
  /// What is indexed of the first time step; null where it is not told, or where the sample is of another
  /// one. It stays valid without this object.
  std::shared_ptr<FinishedLayers> GetFinished() const
  {
    return this->Sample.Step == 0 ? this->Finished : nullptr;
  }
  /// Whether there is a sample on all ranks that is much larger than the last one, or an error that
  /// kept it from being made: the samples that are indexed are made a volume beside the calling
  /// thread. False while exact layers are shown, which cover the same part of the file, and while
  /// the sample is of another time step than the first one. Collective.
  bool HasLargerSample(Communicator& ranks);
  /// Makes that the sample; of all ranks, or of none. Collective.
  Status EnlargeSample(Communicator& ranks);

  /// Waits for the end, at most `seconds`; whether the writing has ended on all ranks.
  /// Collective.
  bool Advance(Communicator& ranks, double seconds)
  {
    return this->Writing->Advance(ranks, seconds);
  }
  /// Waits for the end (CollectiveTask::Finish). Collective.
  Status Finish(Communicator& ranks, const Progress& progress)
  {
    this->IsAwaited = true;
    return this->Writing->Finish(ranks, progress);
  }
  /// Whether the writing waits for a larger budget.
  bool IsWaiting() const { return this->Waits; }
  /// Asks it to stop, without waiting for that. Then it ends with StatusCode::Aborted.
  void Stop() { this->Writing->Stop(); }
  /// The finished fraction, 0 to 1.
  double GetProgress() const { return this->Writing->GetProgress(); }
  /// Seconds until the end, if it goes on as before; negative if that is not known yet. The part
  /// that an earlier try has left does not count for the pace.
  double EstimateSeconds() const;

  /// How it ended, and what of the source is left out (WriteSourceIndex). Only after Advance() has
  /// returned true.
  const Status& GetStatus() const { return this->Writing->GetStatus(); }
  const std::string& GetLeftOut() const { return this->LeftOut; }
  /// Whether the index is of the source as it is now. Only after it has ended well.
  bool IsCurrent() const;
  /// Whether the index is not in its place.
  bool IsInMemory() const { return this->Memory != nullptr; }
  /// The volume, which stays valid without this object. Only after it has ended well.
  Result<std::shared_ptr<BlockedVolume>> Open(const GridPlace& place) const;

private:
  /// Fetches a larger sample than one of this level and so many vertices, which took so long.
  Status FetchFiner(Communicator& ranks, int level, std::int64_t vertices, double seconds,
    const Progress& progress);
  /// Waits while the budget is far too small. Collective.
  Status WaitForBudget(Communicator& ranks, const Progress& advance);
  /// Each rank tells the others what it has sampled, now and then.
  Status GatherSamples(Communicator& ranks);
  /// Begins to make the volume of the slices of the sample that all ranks know, if these are many more
  /// than those that are shown.
  Status BeginEnlarging(Communicator& ranks);

  const SourceIndex Index;
  FileSystem& Files;
  SourceSample Sample;
  std::unique_ptr<SampleCollector> Collector; ///< null if the sample is of all of the volume
  std::shared_ptr<FinishedLayers> Finished;
  std::shared_ptr<MemoryFileSystem> Memory; ///< null if the index can be written to its place
  std::chrono::steady_clock::time_point FirstTime; ///< that of FirstProgress, written before it
  SourceSample Larger;                             ///< a thread's until it has ended, or HasFiner
  bool FetchesFiner = false;                       ///< the same on all ranks
  std::atomic<bool> HasFiner = false;
  std::unique_ptr<BackgroundTask> Enlarging; ///< makes it; null if nothing is much larger
  Status BeginStatus;                        ///< of the last BeginEnlarging; the same on all ranks
  std::int64_t CommonSlices = 0;             ///< complete on all ranks
  std::uint64_t GatheredSteps = 0;           ///< of the work when samples were gathered last
  std::string LeftOut;                       ///< the thread's until it has ended
  std::atomic<bool> IsAwaited = false;
  std::atomic<bool> Waits = false;
  std::atomic<double> FirstProgress = -1;  ///< negative before the first round
  std::unique_ptr<CollectiveTask> Writing; ///< the last member: it uses the others
};

} // namespace isosurface

#endif
