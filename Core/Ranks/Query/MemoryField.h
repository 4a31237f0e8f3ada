// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemoryField_h
#define isosurface_MemoryField_h

#include "Ranks/Query/BackgroundExtraction.h"
#include "Ranks/Query/Field.h"
#include "Ranks/Query/MemoryContour.h"

#include "Ground/Base/Progress.h"

#include <memory>
#include <optional>

namespace isosurface
{

/// Grids in memory. Nobody has counted their triangles, so the first level is found by coarse surfaces;
/// the finest one follows it. Surfaces are extracted by all ranks together.
class MemoryField : public Field
{
public:
  /// Begins an execution. `advance` is called by what is extracted in it, in the calling thread.
  void Ask(MemoryQuery query, Progress advance);
  /// What the surface at a level is extracted of.
  MemoryQuery MakeQuery(int level) const;
  /// This rank's part of the surface at a level. Collective. Errors: this rank's, or those of all ranks.
  Status Extract(Communicator& ranks, int level, ExtractionOutcome& outcome);
  /// Lets the samples go: no finer surface follows.
  void Release() { this->Asked.Samples = {}; }
  /// Forgets the prepared surface, if its thread still reads the samples.
  void DropUnfinished();

  std::string GetName() const override { return "the images of the input"; }
  bool IsSame() const override { return this->Same; }
  int FindFinestLevel(int) const override { return 0; }
  /// Samples, pieces, and pieces that hide something.
  std::vector<std::uint64_t> CountForFirst() const override;
  /// Cost: the surfaces of the coarse levels up to the first one, whose samples the ranks bring to each other
  /// all at once.
  Result<First> FindFirst(
    Communicator& ranks, const std::vector<std::uint64_t>& sums, int finest) override;
  Result<double> EstimateTriangles(int level) override;
  Status Prepare(Communicator& ranks, int level) override;
  CollectiveTask* GetPrepared() override
  {
    return this->Prepared ? &this->Prepared->GetWork() : nullptr;
  }
  void DropPrepared() override { this->Prepared.reset(); }
  void Forget() override;

private:
  /// Whether coarse levels are contoured as whole grids.
  bool Joins() const;
  /// What coarse surfaces are extracted of, from the coarsest on. The error is this rank's.
  Status MakeQueries(const std::vector<int>& levels, std::vector<MemoryQuery>& queries) const;

  MemoryContour Exact;
  MemoryContour Coarse; ///< of its own, so that ranges of exact ones stay
  MemoryQuery Asked;
  Progress Advance;
  std::uint64_t Identity = 0; ///< of the samples that were asked for
  bool Same = false;
  bool AreSeveral = false;                 ///< whether the ranks have more than one piece together
  std::optional<ExtractionOutcome> Probed; ///< the first surface, until it is taken
  int ProbedLevel = 0;
  double ProbedTriangles = 0; ///< of all ranks
  bool HasBegun = false;      ///< whether all ranks have begun to prepare the exact surface
  std::unique_ptr<BackgroundExtraction> Prepared; ///< uses Exact
};

} // namespace isosurface

#endif
