// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Field_h
#define isosurface_Field_h

#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Ranks/Query/Refinement.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace isosurface
{

/**
 * What isosurfaces are extracted of, and what is asked of it: isovalues, region, the share of this rank.
 * A blocked volume (StoredField), or images in memory (MemoryField). Level 0 is the finest. Each has a
 * function Ask, which is called before SurfaceRefinement::Begin.
 *
 * All functions are for one thread. Those with `ranks` are collective.
 */
class Field
{
public:
  /// Where the surfaces after a change begin.
  struct First
  {
    int Level = 0;
    bool IsDirect = false; ///< whether the finest level follows it
  };

  virtual ~Field() = default;

  /// Of what the samples are, for errors.
  virtual std::string GetName() const = 0;
  /// Whether this rank's samples are those that were asked for the last time but one.
  virtual bool IsSame() const = 0;
  /// Whether surfaces can be extracted after the execution that has asked.
  virtual bool IsThere() const = 0;
  /// The finest level that is extracted if `level` is asked for.
  virtual int FindFinestLevel(int level) const = 0;
  /// The first surface of a change, if `finest` is the last one.
  virtual Result<First> FindFirst(Communicator& ranks, int finest) = 0;
  /// The level that follows `level`, which is coarser than `finest`.
  virtual int GetNextLevel(int level, int finest) const = 0;
  /// That of a level, or of the finest coarser one that is expected to keep the budget.
  virtual Result<int> FitLevel(Communicator&, int level) { return level; }
  /// Of all ranks.
  virtual Result<double> EstimateTriangles(int level) = 0;
  /// The memory in bytes that a rank needs for its part of `triangles` triangles; 0 if that is not
  /// known.
  virtual double EstimateBytes(double triangles) const = 0;

  /// This rank's part of the surface at a level, the prepared one if it is that. Cost.Level is coarser
  /// if the level does not keep the budget. Errors: this rank's, or those of all ranks.
  virtual Status Extract(Communicator& ranks, int level, ExtractionOutcome& outcome) = 0;
  /// Begins to extract the surface at a level beside the calling thread, in place of an earlier one. The
  /// error is this rank's.
  virtual Status Prepare(Communicator& ranks, int level) = 0;
  /// The work of that; null if there is none.
  virtual CollectiveTask* GetPrepared() = 0;
  virtual void DropPrepared() = 0;
  /// Forgets the surfaces of an earlier change.
  virtual void Forget() { this->DropPrepared(); }

  ///@{
  /// Of a sample of a volume that is being written: its surface becomes exact, part by part.
  /// Whether the volume is the one that was sampled for the surface before.
  virtual bool IsOfLastSample() const { return false; }
  /// Whether the surface may stay when the volume is there. The argument: whether it
  /// may become exact.
  virtual bool BeginSample(bool) { return false; }
  virtual bool Grows() const { return false; }
  /// Prepares a surface with more exact layers, if it is time for them. Then come the triangles that this
  /// rank shows, and the bytes of memory that it can still have; 0 if that is not known.
  virtual Refinement Grow(Communicator&, std::size_t, std::uint64_t) { return {}; }
  /// The prepared surface is the next one; or, if it has failed on some rank, no other follows.
  virtual void EndGrowth(bool) {}
  ///@}
};

} // namespace isosurface

#endif
