// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeRefinement_h
#define isosurface_VolumeRefinement_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Ranks/Query/Refinement.h"
#include "Ranks/Query/VolumeContour.h"
#include "Storage/Store/BlockedVolume.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace isosurface
{

/// Which surfaces of a volume are wanted. Equal on all ranks, except for Change.
struct RefinementRequest
{
  int Level = 0; ///< the finest level
  ExtractionBudget Budget;
  bool IsProgressive = false; ///< a script asks for one level after the other
  bool MayBeCoarse = false;   ///< a window refines the first surface after a change
  bool FindsIslands = false;  ///< which a sample and its exact layers do not have in common
  std::uint64_t Change = 0;   ///< names the caller's last change
};

/**
 * Isosurfaces of blocked volumes from coarse to fine. Begin chooses the level of the next surface,
 * and Extract extracts it. Between two surfaces, Prepare extracts the finer one beside the calling
 * thread, and Refine makes it the next one. A surface of a sample (FinishedLayers) becomes exact part
 * by part, and stays if the first surface of the volume itself has no more triangles.
 *
 * All functions are for one thread. What they return is equal on all ranks, except for statuses.
 */
class VolumeRefinement
{
public:
  /// `findFreeMemory`: the bytes that this rank can still have; 0 if that is not known.
  explicit VolumeRefinement(std::function<std::uint64_t()> findFreeMemory);

  /// What Begin has chosen.
  struct Choice
  {
    int Level = 0;
    bool MayStay = false; ///< whether the surface may stay when the volume of the sample is there
    bool Stays = false;   ///< whether the last surface stays, so that nothing is to be extracted
  };

  /// Chooses the level of the next surface: the one that Refine has chosen or, if the volume, the time
  /// step or `wanted.Change` is new on any rank, the first one. Gives `task` its exact layers.
  /// `sampled`: the path of the volume that the task's volume is a sample of, or empty. Errors: those of
  /// EstimateTriangles, or that the ranks see different files. Collective: a reduction, two after a
  /// change.
  Result<Choice> Begin(Communicator& ranks, ExtractionTask& task, const std::string& sampled,
    const RefinementRequest& wanted);
  /// This rank's part of the surface that Begin has chosen. Collective if the request has a budget or the
  /// task shares blocks. Errors: as ExtractLevel.
  Status Extract(Communicator& ranks, const ExtractionTask& task, ExtractionOutcome& outcome);
  /// Whether no finer surface follows.
  bool IsFinal() const { return this->Last.IsFinal; }
  /// Tells whether the surface is shown, and the triangles of this rank's part.
  void SetShown(bool shown, std::size_t triangles);

  /// Makes the next surface a finer one, unless the last one is final or `change` is another one.
  bool Refine(std::uint64_t change);
  /// Names the change that Refine itself has made.
  void KeepChange(std::uint64_t change) { this->Last.Wanted.Change = change; }

  /// Begins to extract the next surface beside the calling thread, or waits for it, at most so many
  /// seconds. Stage None: nothing follows. Collective: a reduction while the thread works.
  Refinement Prepare(Communicator& ranks, double seconds, std::uint64_t change);
  /// Forgets what was prepared.
  void DropPrepared() { this->Contour.DropPrepared(); }
  /// Forgets the last surface, too.
  void Forget();
  /// Lets surfaces be larger than the memory until the next change.
  void AcceptSize() { this->Last.SizeAccepted = true; }

  const ExtractionRate& GetRate() const { return this->Contour.GetRate(); }

private:
  using Clock = std::chrono::steady_clock;

  /// The surface that Begin has chosen last.
  struct Pass
  {
    int Level = 0;
    bool Shown = false;
    bool IsFinal = false;
    RefinementRequest Wanted;
    std::weak_ptr<BlockedVolume> Volume;
    ExtractionTask Task;       ///< without the volume
    std::size_t Triangles = 0; ///< of this rank
    bool SizeAccepted = false;
    bool IsDirect = false; ///< whether the final level follows the first one
    std::string Sampled;   ///< the volume until whose finer surface this one may stay; or empty
    bool Stays = false;    ///< whether the surface of the pass before is shown
    std::shared_ptr<const void> AreShown; ///< null before any exact layers are extracted
    Clock::time_point GrowthBegin;        ///< when extracting them began
    Clock::time_point GrowthDue;          ///< before which the next ones do not begin
    bool HasGrown = false;                ///< whether GrowthDue is to be found
    bool GrowthEnded = false;             ///< whether an extraction has failed on any rank
  };

  /// What all ranks know of the surface that is prepared.
  struct Preparation
  {
    bool Grows = false;   ///< exact layers follow
    bool Refines = false; ///< a finer level follows
    bool Exists = false;
    bool IsReady = false;
    bool HasFailed = false; ///< on any rank
    double Share = 0;
  };

  /// Chooses the first level after a change; this rank alone. `shown`: the triangles that are shown of a
  /// sample, which may stay; or 0.
  Status ChooseFirst(const ExtractionTask& task, const std::string& sampled, std::uint64_t shown);
  Status ChooseLevelThatStays(const ExtractionTask& task, std::uint64_t shown);
  /// The level that follows the last one.
  int GetNextLevel(const BlockedVolume& volume) const;
  bool MayRefine(std::uint64_t change) const;
  /// Whether the last surface is of a sample at its finest level, and may have exact layers.
  bool MayGrow(std::uint64_t change) const;
  /// Waits for the prepared surface. Collective: a reduction.
  Preparation Wait(Communicator& ranks, double seconds, std::uint64_t change);
  /// Begins to extract a finer level, unless it is too large. Collective.
  Status BeginLevel(Communicator& ranks);
  /// What the next level takes, and the finest level that fits into memory. Collective.
  Status FindFittingLevel(Communicator& ranks, BlockedVolume& volume, bool& isSizeAccepted);
  /// Begins to extract, which takes memory and a thread; this rank alone.
  Status BeginExtraction(
    const std::shared_ptr<BlockedVolume>& volume, int level, std::int64_t finishedSlices);
  /// Begins to extract more exact layers, if it is time for them. Collective.
  Refinement BeginGrowth(Communicator& ranks);
  /// How many slices of exact layers the surface is to have, and its triangles. Collective.
  std::int64_t ChooseFinishedSlices(
    Communicator& ranks, std::int64_t finished, Refinement& refinement) const;
  /// Whether it is time for so many, and there is memory. Collective.
  bool IsGrowthDue(Communicator& ranks, std::int64_t slices, Refinement& refinement);

  const std::function<std::uint64_t()> FindFreeMemory;
  VolumeContour Contour;
  Pass Last;
  Refinement Next; ///< of the surface that follows
};

} // namespace isosurface

#endif
