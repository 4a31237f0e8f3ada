// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredField_h
#define isosurface_StoredField_h

#include "Ranks/Query/BackgroundExtraction.h"
#include "Ranks/Query/ExtractionRate.h"
#include "Ranks/Query/Field.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/LevelExtraction.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

namespace isosurface
{

/// The maximum number of triangles of the first surface, relative to the final one.
constexpr double FirstSurfaceShare = 1.0 / 20;

/// Up to this number of triangles, no intermediate level is shown between the first surface and the
/// final one. The samples of an index in place may have to be decompressed, which takes longer.
constexpr double DirectSurfaceTriangles = 20'000'000;
constexpr double DirectSurfaceTrianglesInPlace = 10'000'000;

/// A blocked volume, whose spectra tell what each level costs. It learns this machine's speed from every
/// extraction. One surface may be prepared beside the calling thread, by this rank alone.
class StoredField : public Field
{
public:
  /// Begins an execution. Of the task, the volume is not kept alive.
  void Ask(const ExtractionTask& task, const ExtractionBudget& budget);
  const ExtractionRate& GetRate() const { return this->Rate; }

  /**
   * This rank's part of the surface at a level, the prepared one if it is that. With a budget, at the
   * finest level, `level` or coarser, that is expected to keep it; one that turns out to have more
   * triangles is given up for the next. Collective with a budget, or if the task shares blocks. Errors:
   * those of reading the volume; Aborted when the progress says so.
   */
  virtual Status Extract(Communicator& ranks, int level, ExtractionOutcome& outcome);

  std::string GetName() const override { return this->GetVolume()->GetPath(); }
  bool IsSame() const override { return this->Same; }
  bool IsThere() const override { return !this->Volume.expired(); }
  int FindFinestLevel(int level) const override;
  /// The finest one coarser than `finest` with at most FirstSurfaceShare of the triangles at `finest`, and
  /// at most FirstSurfaceTriangles. If no level is as coarse, or the surface is estimated to vanish there,
  /// the coarsest level with triangles. Cost: the spectra of the volume, which it keeps.
  Result<First> FindFirst(
    Communicator& ranks, const std::vector<std::uint64_t>& sums, int finest) override;
  /// The finest level, but not finer than `finest`, that is stored in the same blocks as the next finer
  /// one. Coarser levels there would read as many blocks for a fraction of the triangles.
  int GetNextLevel(int level, int finest) const override;
  Result<int> FitLevel(Communicator& ranks, int level) override;
  Result<double> EstimateTriangles(int level) override;
  double EstimateBytes(double triangles) const override;
  Status Prepare(Communicator& ranks, int level) override;
  CollectiveTask* GetPrepared() override;
  void DropPrepared() override;

protected:
  /// An extraction at a level, by this rank. It keeps what it uses, so that a thread can.
  using Extraction =
    std::function<Status(const ExtractionTask& task, int level, ExtractionOutcome& outcome)>;

  /// Null when the execution has ended, and nobody else has it.
  std::shared_ptr<BlockedVolume> GetVolume() const { return this->Volume.lock(); }
  /// Without the volume.
  const ExtractionTask& GetTask() const { return this->Task; }
  bool HasBudget() const { return this->Budget.IsLimited(); }
  /// The surface that was prepared as `variant` of a level, or else what `extract` gives.
  Status Take(
    int level, std::int64_t variant, const Extraction& extract, ExtractionOutcome& outcome);
  /// Begins to extract a variant beside the calling thread, in place of an earlier one.
  Status PrepareVariant(int level, std::int64_t variant, Extraction extract);

private:
  /// What a prepared surface and the task have in common: level, share, variant, and epoch of the volume,
  /// since other shares belong to another one.
  using Key = std::array<std::int64_t, 5>;

  ExtractionTask MakeTask() const;
  static Key MakeKey(const ExtractionTask& task, int level, std::int64_t variant);
  Result<LevelChoice> ChooseLevel(
    Communicator& ranks, int finest, const ExtractionBudget& budget, QueryStatistics& statistics);
  Status ExtractAtLevel(const LevelChoice& choice, ExtractionOutcome& outcome);
  /// Learns the speed of this machine from a coarse level, which costs little. Collective.
  Status Probe(Communicator& ranks, int finest, QueryStatistics& reading);
  Status ExtractWithinBudget(Communicator& ranks, int finest, ExtractionOutcome& outcome);

  std::weak_ptr<BlockedVolume> Volume;
  ExtractionTask Task; ///< without the volume
  ExtractionBudget Budget;
  bool Same = false;
  ExtractionRate Rate;
  bool HasProbed = false; ///< whether a coarse level has been extracted to learn the speed
  std::unique_ptr<BackgroundExtraction> Prepared;
  Key PreparedKey{};
  std::unique_ptr<BackgroundExtraction> Dropped; ///< so that nobody waits for its end
};

} // namespace isosurface

#endif
