// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Field_h
#define isosurface_Field_h

#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/Refinement.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// The maximum number of triangles of the first surface: two cores without a graphics card extract
/// and draw this number in about a tenth of a second.
constexpr double FirstSurfaceTriangles = 100'000;

/**
 * What is made of samples from coarse to fine (FieldRefinement), and what is asked of it: an isosurface of
 * a blocked volume (StoredField) or of images in memory (MemoryField), a slice. Level 0 is the finest.
 * Each has a function Ask, which is called before FieldRefinement::Begin, and one that gives the result at
 * a level: the prepared one, if it is that.
 *
 * All functions are for one thread. Those with `ranks` are collective.
 */
class Field
{
public:
  /// What the results after a change begin with.
  struct First
  {
    int Level = 0;
    bool IsDirect = false; ///< whether the finest level follows it
    bool IsCommon = false; ///< whether it cannot but be the same on all ranks
  };

  virtual ~Field() = default;

  /// Of what the samples are, for errors.
  virtual std::string GetName() const = 0;
  /// Whether this rank's samples are those that were asked for the last time but one.
  virtual bool IsSame() const = 0;
  /// Whether finer results can be made after the execution that has asked.
  virtual bool IsThere() const { return true; }
  /// The finest level that is made if `level` is asked for.
  virtual int FindFinestLevel(int level) const = 0;
  /// What FindFirst has to know of this rank, as numbers to be summed; as many on all ranks.
  virtual std::vector<std::uint64_t> CountForFirst() const { return {}; }
  /// The first result of a change, if `finest` is the last one. `sums`: CountForFirst of all ranks.
  virtual Result<First> FindFirst(
    Communicator& ranks, const std::vector<std::uint64_t>& sums, int finest) = 0;
  /// The level that follows `level`, which is coarser than `finest`.
  virtual int GetNextLevel(int, int finest) const { return finest; }
  /// That of a level, or of the finest coarser one that is expected to keep the budget.
  virtual Result<int> FitLevel(Communicator&, int level) { return level; }
  /// Of all ranks.
  virtual Result<double> EstimateTriangles(int) { return 0; }
  /// The memory in bytes that a rank needs for its part of `triangles` triangles; 0 if that is not
  /// known.
  virtual double EstimateBytes(double) const { return 0; }

  /// Begins to make the result at a level beside the calling thread, in place of an earlier one. The
  /// error is this rank's.
  virtual Status Prepare(Communicator& ranks, int level) = 0;
  /// The work of that; null if there is none.
  virtual CollectiveTask* GetPrepared() = 0;
  virtual void DropPrepared() = 0;
  /// Forgets the results of an earlier change.
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
