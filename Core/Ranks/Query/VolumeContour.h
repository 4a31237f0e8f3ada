// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeContour_h
#define isosurface_VolumeContour_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/BackgroundExtraction.h"
#include "Ranks/Query/ExtractionRate.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/LevelExtraction.h"

#include <array>
#include <cstdint>
#include <memory>

namespace isosurface
{

/// Extracts isosurfaces of blocked volumes, at a given level or at the finest one that a budget
/// allows. It learns this machine's speed from every extraction. One surface may be prepared beside
/// the calling thread.
class VolumeContour
{
public:
  /// This rank's part of the surface at `choice.Level`, the prepared one if it is of that level and
  /// of the same share. Collective if the task shares blocks, else not. Errors: those of reading
  /// the volume; Aborted when the progress says so.
  Status ExtractAtLevel(
    const ExtractionTask& task, const LevelChoice& choice, ExtractionOutcome& outcome);

  /// The same at the finest level, `finest` or coarser, that is expected to keep the budget. One
  /// that turns out to have more triangles is given up for the next. Collective.
  Status ExtractWithinBudget(Communicator& ranks, const ExtractionBudget& budget,
    const ExtractionTask& task, int finest, ExtractionOutcome& outcome);

  /// Begins to extract a surface beside the calling thread, in place of an earlier one.
  void Prepare(ExtractionTask task, int level);
  /// Forgets the prepared surface, whose threads end soon afterwards. To be called when another
  /// volume or query is extracted next: that of a prepared surface is not compared.
  void DropPrepared();
  /// The work of the prepared surface, finished or not; null if there is none.
  CollectiveTask* GetPrepared() { return this->Prepared ? &this->Prepared->GetWork() : nullptr; }

  const ExtractionRate& GetRate() const { return this->Rate; }

private:
  /// What a prepared surface and a task have in common: level, share, slices of exact layers, and epoch of
  /// the volume, since other shares belong to another one.
  using Key = std::array<std::uint64_t, 5>;
  static Key MakeKey(const ExtractionTask& task, int level);
  /// Whether the prepared surface is that of the task; the same on all ranks that share blocks.
  bool IsPrepared(const ExtractionTask& task, int level) const;

  ExtractionRate Rate;
  bool HasProbed = false; ///< whether a coarse level has been extracted to learn the speed
  std::unique_ptr<BackgroundExtraction> Prepared;
  Key PreparedKey{};
  std::unique_ptr<BackgroundExtraction> Dropped; ///< so that nobody waits for its end
};

} // namespace isosurface

#endif
