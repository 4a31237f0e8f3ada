// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourExecution_h
#define isosurface_ContourExecution_h

#include "CellArrays.h"
#include "ControllerCommunicator.h"
#include "ImagePieces.h"
#include "SurfaceFieldData.h"
#include "VolumeInput.h"

#include "vtkType.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/Region.h"
#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/FieldRefinement.h"
#include "Ranks/Query/GrowingField.h"
#include "Ranks/Query/MemoryField.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "SurfacePolyData.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkInformation;
class vtkStabbingContour;

namespace isosurface
{

struct ContourBlocks;

/// Of one execution, on this rank.
struct ContourOutcome : ExtractionOutcome
{
  std::vector<InterpolatedArray> Arrays; ///< of the surface's attributes
  std::string ArrayName;                 ///< of the contoured array
  SurfaceBlocks Blocks; ///< of the input, if it has several with surfaces of their own
  bool MayStay = false; ///< whether the next execution may have it stay
  bool Stays = false;   ///< whether nothing was extracted, and the last surface stays
  std::size_t ExtractedTriangles = 0;   ///< before islands were left out
  std::optional<ChosenIslands> Islands; ///< if they were asked for
  double IslandSeconds = 0;             ///< wall clock of finding and choosing them
};

/// What an error of a shortage of memory says.
constexpr const char* NotExtracted = "the isosurface cannot be extracted";

/**
 * What a vtkStabbingContour does: its properties become a query, the query becomes a surface, or
 * the blocks that the surface is made of. Keeps what a later execution can use: value ranges of
 * images, how fast this machine extracts, and the level of a progressive surface.
 */
class ContourExecution
{
public:
  explicit ContourExecution(vtkStabbingContour& contour);
  static ContourExecution& Of(vtkStabbingContour& contour);

  /// This rank's piece of the surface. The caller has all ranks agree on the status. Collective.
  Status Extract(vtkInformation* inInfo, vtkInformation* outInfo, ContourOutcome& outcome);

  /// See CollectContourBlocks.
  Status CollectBlocks(
    int piece, int pieces, const std::optional<double>& time, ContourBlocks& blocks);

  /// The surfaces from coarse to fine; a change is the filter's MTime.
  FieldRefinement& GetSurfaces() { return this->Surfaces; }
  /// Tells whether all ranks have what Extract has given. Whether it is final.
  bool SetShown(bool shown, const ContourOutcome& made);
  /// Whether surfaces after a change may be coarse though the filter is not progressive.
  void AllowCoarse(bool allowed) { this->CoarseAllowed = allowed; }

  /// Stops reading images beside the calling thread, so that the filters upstream may execute.
  void ReleaseImages() { this->InMemory.DropUnfinished(); }

  ControllerCommunicator GetRanks();
  int ChooseThreads(); ///< collective at the first call

private:
  ContourRequest MakeRequest();
  Region MakeRegion();
  IslandRequest MakeIslandRequest(int level);
  std::string GetArrayToContour();
  std::vector<std::string> ChooseInterpolatedArrays(const std::string& contoured);

  /// Agrees on whether the input is a blocked volume, and on the query, so that all ranks take the
  /// same branch. `query` is made for a volume alone. `blocks`: those to give in place of a
  /// surface, or null. Collective.
  Status AgreeOnQuery(const VolumeInput& input, Communicator& ranks, SurfaceQuery& query,
    ContourOutcome& outcome, const ContourBlocks* blocks);
  /// Makes the query of a blocked volume, and names the arrays of the output; this rank alone.
  Status MakeQuery(const VolumeInput& input, SurfaceQuery& query, ContourOutcome& outcome);
  /// A checksum of the properties that decide about the surface of all ranks, or about its blocks.
  std::uint64_t ComputeFingerprint(const SurfaceQuery& query, const ContourBlocks* blocks);
  Status ExtractFromVolume(const VolumeInput& input, const SurfaceQuery& query,
    vtkInformation* outInfo, ContourOutcome& outcome);
  Status ExtractOnce(const VolumeInput& input, const ExtractionTask& task, ContourOutcome& outcome);
  /// The bytes of memory that this rank can still have; 0 if that is not known.
  std::uint64_t FindFreeMemory();
  void WarnOfLackOfMemory(const ExtractionTask& task, int level);
  RefinementRequest MakeRefinementRequest();
  Status ExtractFromImages(vtkInformation* inInfo, ContourOutcome& outcome);
  /// Applies the island filter, if the properties ask for one. `extracted`: this rank's status of the
  /// extraction. `makeGrids` gives the grids of the surface. Collective.
  Status ChooseIslands(Communicator& ranks, const Status& extracted,
    const std::function<IslandGrids()>& makeGrids, ContourOutcome& outcome);
  /// The images of all ranks that are to be contoured, and what is asked of them; they live with
  /// `pieces`. `interpolates`: whether other arrays are wanted. Collective; the error may be this rank's.
  Result<MemoryQuery> CollectImages(Communicator& ranks, vtkInformation* inInfo, bool interpolates,
    ImagePieces& pieces, ContourOutcome& outcome);

  /// This rank alone knows its outcome.
  Status UpdateInput(int piece, int pieces, const std::optional<double>& time);
  Status CollectBlocksOfVolume(Communicator& ranks, const VolumeInput& input, SurfaceQuery query,
    ContourOutcome& outcome, ContourBlocks& blocks);
  Status CollectBlocksOfImages(
    Communicator& ranks, vtkInformation* inInfo, ContourOutcome& outcome, ContourBlocks& blocks);

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
