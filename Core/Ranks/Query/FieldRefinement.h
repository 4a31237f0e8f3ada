// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FieldRefinement_h
#define isosurface_FieldRefinement_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/Field.h"
#include "Ranks/Query/Refinement.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace isosurface
{

/// Which results of a field are wanted. Level and IsProgressive are equal on all ranks.
struct RefinementRequest
{
  int Level = 0;              ///< the finest level
  bool IsProgressive = false; ///< a script asks for one level after the other
  bool MayBeCoarse =
    false; ///< a window refines the first result after a change, if all ranks say so
  bool FindsIslands = false; ///< which a sample and its exact layers do not have in common
  std::uint64_t Change = 0;  ///< names the caller's last change
};

/**
 * Isosurfaces, or slices, from coarse to fine. Begin chooses the level of the next one, which the caller
 * makes. Between two of them, Prepare makes the finer one beside the calling thread, and Refine makes it
 * the next one. A surface of a sample (GrowingField) becomes exact part by part, and stays if the first
 * surface of the volume itself has no more triangles.
 *
 * All functions are for one thread. What they return is equal on all ranks, except for statuses.
 */
class FieldRefinement
{
public:
  /// `findFreeMemory`: the bytes that this rank can still have; 0 if that is not known.
  explicit FieldRefinement(
    std::function<std::uint64_t()> findFreeMemory = [] { return std::uint64_t{ 0 }; });

  /// What Begin has chosen.
  struct Choice
  {
    int Level = 0;
    bool MayStay = false; ///< whether the surface may stay when the volume of the sample is there
    bool Stays = false;   ///< whether the last surface stays, so that nothing is to be extracted
    bool IsFinal = false; ///< whether no finer level follows
  };

  /// Chooses the level of the next surface: the one that Refine has chosen or, if on any rank the field
  /// has other samples or `wanted.Change` is new, the first one. `field` must outlive this object. `asked`:
  /// whether this rank has asked it. Errors: that of any rank, those of the field, or that the ranks see
  /// different files. Collective: a reduction; after a change, if the first one may be coarse, also what
  /// Field::FindFirst needs, and an agreement unless the field knows that the ranks agree.
  Result<Choice> Begin(Communicator& ranks, Field& field, const RefinementRequest& wanted,
    const Status& asked = Status::Ok());
  /// Tells whether what Begin has chosen is shown, at which level, and the triangles of this rank's part. A
  /// level that is coarser than the chosen one is final: what forbids this one forbids finer ones, too.
  void SetShown(bool shown, int level, std::size_t triangles);
  /// Whether no finer result follows.
  bool IsFinal() const { return this->Last.IsFinal; }
  /// Whether the next result, after Refine perhaps, is at the finest level.
  bool IsNextFinest() const { return this->Last.Level <= this->Last.Wanted.Level; }

  /// Makes the next surface a finer one, unless the last one is final or `change` is another one.
  bool Refine(std::uint64_t change);
  /// Names the change that Refine itself has made.
  void KeepChange(std::uint64_t change) { this->Last.Wanted.Change = change; }

  /// Begins to extract the next surface beside the calling thread, or waits for it, at most
  /// `seconds`. Stage None: nothing follows. Collective: a reduction while the thread works, and
  /// those of CollectiveTask::Advance.
  Refinement Prepare(Communicator& ranks, double seconds, std::uint64_t change);
  /// Forgets the prepared surface.
  void DropPrepared();
  /// Lets surfaces be larger than the memory until the next change.
  void AcceptSize() { this->Last.SizeAccepted = true; }

private:
  /// The surface that Begin has chosen last.
  struct Pass
  {
    Field* Of = nullptr;
    int Level = 0;
    bool Shown = false;
    bool IsFinal = false;
    RefinementRequest Wanted;  ///< its level is one of the field
    std::size_t Triangles = 0; ///< of this rank
    bool SizeAccepted = false;
    bool IsDirect = false; ///< whether the final level follows the first one
    bool MayStay = false;  ///< until there is a finer surface of the volume that was sampled
    bool Stays = false;    ///< whether the surface of the pass before is shown
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

  void Forget();
  /// Chooses the first level after a change, and agrees on it. `shown`: the triangles that are shown of a
  /// sample, which may stay; or 0. `sums`: as Field::FindFirst takes them. Collective.
  Status ChooseFirst(
    Communicator& ranks, Field& field, const std::vector<std::uint64_t>& sums, std::uint64_t shown);
  Status ChooseLevelThatStays(Communicator& ranks, Field& field, std::uint64_t shown);
  /// The level that follows the last one.
  int GetNextLevel(const Field& field) const;
  bool IsCurrent(std::uint64_t change) const;
  bool MayRefine(std::uint64_t change) const;
  /// Whether the last surface is of a sample at its finest level, and may have exact layers.
  bool MayGrow(std::uint64_t change) const;
  /// Waits for the prepared surface. Collective.
  Preparation Wait(Communicator& ranks, double seconds, std::uint64_t change);
  /// Goes on with exact layers of a sample. Collective.
  Refinement PrepareGrowth(Communicator& ranks, const Preparation& prepared);
  /// Begins to extract a finer level, unless it is too large. Collective.
  Status BeginLevel(Communicator& ranks);
  /// What the next level takes, and the finest level that fits into memory. Collective.
  Status FindFittingLevel(Communicator& ranks, bool& isSizeAccepted);

  const std::function<std::uint64_t()> FindFreeMemory;
  Pass Last;
  Refinement Next; ///< of the surface that follows
};

} // namespace isosurface

#endif
