// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageRefinement_h
#define isosurface_ImageRefinement_h

#include "ImageContour.h"

#include "vtkType.h"

#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/Refinement.h"

#include <cstddef>
#include <cstdint>
#include <memory>

class vtkAlgorithm;

namespace isosurface
{

/// Surfaces of images in memory: a coarse one after a change, and the exact one, which is made beside
/// the calling thread.
class ImageRefinement
{
public:
  /// Of a filter, whose progress it reports, and whose changes end a refinement.
  explicit ImageRefinement(vtkAlgorithm& filter);

  /// The surface that is asked for: of the level that Refine() has chosen, or after a change of the
  /// filter or of the images a coarse one, if it may be coarse on all ranks, else the exact one.
  /// Collective.
  Status Extract(
    Communicator& ranks, ImageContour::Query query, bool mayBeCoarse, ContourOutcome& outcome);
  /// The grids of the surface that was extracted last. Collective.
  IslandGrids MakeIslandGrids(Communicator& ranks) const;
  /// Ends an execution. Lets the images go, unless the surface may be refined.
  void End();
  /// See ContourExecution.
  void SetShown(bool shown, std::size_t triangles);
  void KeepPass(vtkMTimeType time) { this->Last.Time = time; }

  /// Whether the last surface can be refined, as this rank sees it.
  bool MayRefine() const;
  /// Makes the next surface the exact one; false if there is nothing to refine.
  bool Refine();
  /// Extracts the exact surface beside the calling thread; see ContourExecution::PrepareRefinement.
  /// Collective.
  Refinement Prepare(Communicator& ranks, double seconds);
  /// Forgets what was prepared.
  void Drop() { this->Prepared.reset(); }
  /// The same, if it still reads the images.
  void DropUnfinished();
  /// Forgets the last surface, too: the input has no images.
  void Forget()
  {
    this->Drop();
    this->Last = {};
  }

private:
  /// What the last execution was made of.
  struct Pass
  {
    int Level = 0;          ///< 0: nothing is finer
    bool HasPieces = false; ///< whether the ranks have more than one together
    bool Shown = false;
    vtkMTimeType Time = 0;   ///< of the filter
    std::uint64_t Input = 0; ///< a fingerprint of the images
    ImageContour::Query Exact;
    std::size_t Triangles = 0;
  };

  /// The exact surface, made beside the calling thread.
  struct ExactSurface
  {
    ContourOutcome Outcome;               ///< the thread's until it has ended
    std::unique_ptr<CollectiveTask> Work; ///< the last member: it uses the other one
  };

  /// Remembers what this execution extracts. Returns the vertices of all ranks if it is the first one
  /// of the images and may be coarse, else 0. Collective.
  std::uint64_t Begin(Communicator& ranks, ImageContour::Query query, bool mayBeCoarse);
  /// The finest surface that two cores extract and draw within some 0.1 s, if the exact one takes
  /// longer. Chooses the level. Collective.
  Status ExtractFirst(Communicator& ranks, std::uint64_t vertices, ContourOutcome& outcome);
  /// What is contoured at the level.
  ImageContour::Query MakeQuery() const;
  /// The surface of the level. Collective.
  Status ExtractCoarsely(Communicator& ranks, ContourOutcome& outcome);
  /// The exact surface, the prepared one if there is one. Collective.
  Status ExtractExactly(Communicator& ranks, ContourOutcome& outcome);
  /// Begins to extract the exact surface. Collective.
  Status BeginExact(Communicator& ranks);

  vtkAlgorithm& Filter;
  ImageContour Exact;
  ImageContour Coarse; ///< of its own, so that ranges of exact ones stay
  Pass Last;
  Refinement Next;                        ///< of the exact surface
  std::unique_ptr<ExactSurface> Prepared; ///< of Last; uses Exact
};

} // namespace isosurface

#endif
