// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourExecution_h
#define isosurface_ContourExecution_h

#include "CellArrays.h"
#include "ControllerCommunicator.h"
#include "ImagePieces.h"
#include "ImageRefinement.h"
#include "VolumeInput.h"

#include "vtkType.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/Region.h"
#include "Ranks/Query/VolumeRefinement.h"
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

  /// Makes the next execution one of a finer level; false if the surface is final.
  bool Refine();
  /// Tells that the filter was modified by Refine alone.
  void KeepPass(vtkMTimeType time)
  {
    this->OfVolumes.KeepChange(time);
    this->OfImages.KeepPass(time);
  }
  /// Tells whether the surface of the level was extracted, and the triangles of this rank's part.
  void SetShown(bool shown, std::size_t triangles);
  /// Whether surfaces after a change may be coarse though the filter is not progressive.
  void AllowCoarse(bool allowed) { this->CoarseAllowed = allowed; }

  /// Extracts the next finer surface beside the calling thread, which sleeps for at most so many
  /// seconds meanwhile. Returns how far it is. Collective.
  Refinement PrepareRefinement(double seconds);
  /// Forgets what was prepared.
  void DropRefinement();
  /// Stops what reads images beside the calling thread: what is before the filter may execute.
  void ReleaseImages() { this->OfImages.DropUnfinished(); }
  /// Lets surfaces of the current volume and isovalues be larger than the memory.
  void AcceptSize() { this->OfVolumes.AcceptSize(); }

  ControllerCommunicator GetRanks();
  int ChooseThreads(); ///< collective at the first call

private:
  ContourRequest MakeRequest();
  Region MakeRegion();
  IslandRequest MakeIslandRequest(int level);
  std::string GetArrayToContour();
  std::vector<std::string> ChooseInterpolatedArrays(const std::string& contoured);

  /// Whether the input is a blocked volume, and what is asked of it, are the same on all ranks; so
  /// all go the same way. `query` is made for a volume alone. `blocks`: those that are asked for, if
  /// not a surface. Collective.
  Status AgreeOnQuery(const VolumeInput& input, Communicator& ranks, SurfaceQuery& query,
    ContourOutcome& outcome, const ContourBlocks* blocks);
  /// What is asked of a blocked volume, and what the output's arrays will be; this rank alone.
  Status MakeQuery(const VolumeInput& input, SurfaceQuery& query, ContourOutcome& outcome);
  /// A checksum of the properties that decide about the surface of all ranks, or about its blocks.
  std::uint64_t ComputeFingerprint(const SurfaceQuery& query, const ContourBlocks* blocks);
  Status ExtractFromVolume(const VolumeInput& input, const SurfaceQuery& query,
    vtkInformation* outInfo, ContourOutcome& outcome);
  /// `sampled`: as vtkBlockedVolumeHandle has it.
  Status ExtractOnce(ExtractionTask task, const std::string& sampled, ContourOutcome& outcome);
  /// The bytes of memory that this rank can still have; 0 if that is not known.
  std::uint64_t FindFreeMemory();
  void WarnOfLackOfMemory(const ExtractionTask& task, int level);
  Status ExtractFromImages(vtkInformation* inInfo, ContourOutcome& outcome);
  /// Leaves out the islands that are not wanted, if any are wanted, of what ended with `extracted`
  /// on this rank. `makeGrids` gives the grids of the surface. Collective.
  Status ChooseIslands(Communicator& ranks, const Status& extracted,
    const std::function<IslandGrids()>& makeGrids, ContourOutcome& outcome);
  /// The images of all ranks that are to be contoured. Collective.
  Result<ImagePieces> CollectPieces(
    Communicator& ranks, vtkInformation* inInfo, std::string& arrayName);

  /// This rank alone knows its outcome.
  Status UpdateInput(int piece, int pieces, const std::optional<double>& time);
  Status CollectBlocksOfVolume(Communicator& ranks, const VolumeInput& input, SurfaceQuery query,
    ContourOutcome& outcome, ContourBlocks& blocks);
  Status CollectBlocksOfImages(Communicator& ranks, vtkInformation* inInfo, ContourBlocks& blocks);

  vtkStabbingContour& Contour;
  CellAverages Averages;
  ImageRefinement OfImages;
  VolumeRefinement OfVolumes;
  bool CoarseAllowed = false;
  int RanksOnNode = 0; ///< 0: not known yet
};

} // namespace isosurface

#endif
