// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourExecution_h
#define isosurface_ContourExecution_h

#include "IsosurfaceFiltersModule.h"

#include "CellArrays.h"
#include "ControllerCommunicator.h"
#include "ImagePieces.h"
#include "VolumeInput.h"

#include "Ranks/Query/ContourBlocks.h"
#include "Ranks/Query/FieldRefinement.h"
#include "Ranks/Query/GrowingField.h"
#include "Ranks/Query/MemoryField.h"
#include "Ranks/Query/SurfaceRequest.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkInformation;
class vtkObject;
class vtkStabbingContour;

namespace isosurface
{

/// The arrays that a consumer of blocks wants beside the contoured one.
struct BlockArrays
{
  bool Normals = false; ///< samples for gradients
  bool Attributes = false;
};

/// Sets the profile of `consumer` to that of a number that a script or state of any version may have. Warns if there
/// is none of that number.
ISOSURFACEFILTERS_EXPORT void SetProfile(vtkObject* consumer, int number, int& profile);

/// What an error of a shortage of memory says.
constexpr const char* NotExtracted = "the isosurface cannot be extracted";

/// One execution, on this rank: what is asked, and what has come of it.
struct ContourRun : ExtractionOutcome
{
  SurfaceRequest Request;
  SurfaceQuery Query;                    ///< of a blocked volume
  std::vector<InterpolatedArray> Arrays; ///< of the surface's attributes
  std::string ArrayName;                 ///< of the contoured array
  /// The block of each point, and the blocks' names, if the input has several with surfaces of their own.
  std::vector<std::int32_t> Blocks;
  std::vector<std::string> BlockNames;
  bool MayStay = false; ///< whether the next execution may have it stay
  bool Stays = false;   ///< whether nothing was extracted, and the last surface stays
};

/**
 * What a vtkStabbingContour does: its properties become a query, the query becomes a surface, or
 * the blocks that the surface is made of. Keeps what a later execution can use: value ranges of
 * images, how fast this machine extracts, and the level of a progressive surface.
 */
class ContourExecution
{
public:
  explicit ContourExecution(vtkStabbingContour& contour);

  /// This rank's piece of the surface. The caller has all ranks agree on the status. Collective.
  Status Extract(vtkInformation* inInfo, vtkInformation* outInfo, ContourRun& run);

  /// The surfaces from coarse to fine; a change is the filter's MTime.
  FieldRefinement& GetSurfaces() { return this->Surfaces; }
  /// Tells whether all ranks have what Extract has given. Whether it is final.
  bool SetShown(bool shown, const ContourRun& made);
  /// Whether surfaces after a change may be coarse though the filter is not progressive.
  void AllowCoarse(bool allowed) { this->CoarseAllowed = allowed; }

  /// What the filter would contour on this rank, block by block: collects the blocks and has `take` read them, and
  /// once more where it has failed since stores were lost or damaged meanwhile. Rank 0 warns of such stores, as
  /// `consumer`, if all ends well. Brings the filter's input up to date, at that time if one is given; neither makes
  /// nor changes the filter's output. Isovalues, region, arrays and level are those of its properties. Collective.
  ///
  /// Of a blocked volume the blocks are those of Level, or of the finest coarser level that keeps to MaximumTriangles
  /// as far as the contour spectrum can tell. TimeBudget and Progressive have no effect, nor have the options that say
  /// what becomes of the blocks: DropDegenerateTriangles and GenerateTriangles.
  ///
  /// Errors: those of `take`; on all ranks, an input that failed, and those of the filter itself.
  ISOSURFACEFILTERS_EXPORT static Status TakeBlocks(vtkAlgorithm* consumer,
    vtkStabbingContour& contour, Communicator& ranks, const std::optional<double>& time,
    const BlockArrays& wanted, const std::function<Status(ContourBlocks&)>& take);

  /// Stops reading images beside the calling thread, so that the filters upstream may execute.
  void ReleaseImages() { this->InMemory.DropUnfinished(); }

  int ChooseThreads(); ///< collective at the first call

private:
  SurfaceRequest MakeRequest();
  /// `blocks`, here and below: what a consumer of blocks wants; null for a surface.
  std::vector<std::string> ChooseInterpolatedArrays(
    const std::string& contoured, const BlockArrays* blocks);

  /// Agrees on whether the input is a blocked volume, and on the query, so that all ranks take the
  /// same branch. Collective.
  Status AgreeOnQuery(
    const VolumeInput& input, Communicator& ranks, const BlockArrays* blocks, ContourRun& run);
  /// Makes the query of a blocked volume, and names the arrays of the output; this rank alone.
  Status MakeQuery(const VolumeInput& input, const BlockArrays* blocks, ContourRun& run);
  /// A checksum of the properties that decide about the surface of all ranks, or about its blocks.
  std::uint64_t ComputeFingerprint(const ContourRun& run, const BlockArrays* blocks);
  Status ExtractFromVolume(
    const VolumeInput& input, Communicator& ranks, vtkInformation* outInfo, ContourRun& run);
  Status ExtractOnce(
    const VolumeInput& input, Communicator& ranks, const ExtractionTask& task, ContourRun& run);
  /// The bytes of memory that this rank can still have; 0 if that is not known.
  std::uint64_t FindFreeMemory();
  /// Says so before the first rank extracts more than it has memory for. In the window, a question
  /// stands in front of such a surface.
  void WarnOfLackOfMemory(const ExtractionTask& task, int level);
  Status ExtractFromImages(vtkInformation* inInfo, Communicator& ranks, ContourRun& run);
  /// The images of all ranks that are to be contoured, and what is asked of them; they live with
  /// `pieces`. Collective; the error may be this rank's.
  Result<MemoryQuery> CollectImages(Communicator& ranks, vtkInformation* inInfo,
    const BlockArrays* blocks, ImagePieces& pieces, ContourRun& run);

  Status CollectBlocks(const Communicator& consumers, const std::optional<double>& time,
    const BlockArrays& wanted, ContourBlocks& blocks);
  /// This rank alone knows its outcome.
  Status UpdateInput(int piece, int pieces, const std::optional<double>& time);

  vtkStabbingContour& Contour;
  CellAverages Averages;
  GrowingField Stored;
  MemoryField InMemory;
  FieldRefinement Surfaces;
  bool CoarseAllowed = false;
  int RanksOnNode = 0; ///< 0: not known yet
};

} // namespace isosurface

#endif
