// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FetchBudget_h
#define isosurface_FetchBudget_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace isosurface
{

/**
 * What all ranks fetch of a source at an address while its work runs, and how much that may be: each rank its share.
 * A source that is a folder of Zarr or N5 is told from others; of another file, all that is fetched of its folder counts.
 * Any thread may ask it.
 */
class FetchBudget
{
public:
  /// `source`: VolumeName. 0 bytes: no limit.
  FetchBudget(std::string source, std::uint64_t bytes);

  const std::string& GetSource() const { return this->Source; }
  std::uint64_t GetLimit() const { return this->Limit; }
  /// Work that runs obeys it, too.
  void SetLimit(std::uint64_t bytes) { this->Limit = bytes; }
  /// Of all ranks, as Gather() has found it last, and of this one as it is now; of one that has ended, until then.
  std::uint64_t CountFetched() const { return this->CountMine() + this->OfOthers; }
  /// Collective. Tells the ranks what the others have fetched.
  void Gather(Communicator& ranks);
  /// Whether the last work ended since the budget was spent; the same on all ranks.
  bool IsSpent() const { return this->HasEndedWork; }
  /// The bytes of the samples that are wanted, once they are known.
  void SetSampleBytes(std::uint64_t bytes) { this->SampleBytes = bytes; }
  /// Whether this rank, one of `ranks`, has not spent its share.
  bool IsWithin(int ranks) const;
  /// Whether all samples are out of question, however well they are compressed.
  bool IsFarTooSmall() const
  {
    const std::uint64_t limit = this->Limit;
    return limit > 0 && this->SampleBytes / limit >= MostCompressed;
  }

  /// "412 MB of 1.9 TB fetched, at most 4.3 GB"; "" if nothing is.
  std::string Describe() const;

  /**
   * Collective. Runs work, which calls `advance` as its progress, and stops it when a rank has spent its share: then
   * the error, IoError on all ranks, tells that and the fraction of `advance`. Another error of any rank, and a stop
   * by `progress`, stay as they are. What earlier work has fetched counts.
   */
  Status Run(Communicator& ranks, const Progress& progress,
    const std::function<Status(const Progress& advance)>& work);

private:
  static constexpr std::uint64_t MostCompressed = 16;

  std::uint64_t CountMine() const;

  const std::string Source;
  const std::shared_ptr<const std::atomic<std::uint64_t>> Counter;
  std::atomic<std::uint64_t> Limit;
  std::atomic<std::uint64_t> Idle = 0; ///< of Counter, by others than the work
  std::atomic<std::uint64_t> Kept = 0; ///< of the work that has ended
  std::atomic<std::uint64_t> OfOthers = 0;
  std::atomic<std::uint64_t> SampleBytes = 0;
  std::atomic<double> Done = 0;
  std::atomic<bool> IsRunning = false;
  std::atomic<bool> HasEndedWork = false;
};

} // namespace isosurface

#endif
