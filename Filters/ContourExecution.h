// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourExecution_h
#define isosurface_ContourExecution_h

#include "CellArrays.h"
#include "ContourRefinement.h"
#include "ControllerCommunicator.h"
#include "ImagePieces.h"
#include "ImageRefinement.h"
#include "VolumeInput.h"

#include "vtkType.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/Region.h"
#include "Ranks/Query/VolumeContour.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "SurfacePolyData.h"

#include <chrono>
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
    this->LastPass.Time = time;
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
  void AcceptSize() { this->LastPass.SizeAccepted = true; }

  ControllerCommunicator GetRanks();
  int ChooseThreads(); ///< collective at the first call

private:
  using Clock = std::chrono::steady_clock;

  /// What the last execution was made of. A progressive surface goes on from it if neither the
  /// filter, nor the volume, nor the time step has changed.
  struct Pass
  {
    int Level = 0;
    bool Shown = false;    ///< whether the surface of this level was extracted
    vtkMTimeType Time = 0; ///< of the filter
    std::weak_ptr<BlockedVolume> Volume;
    SurfaceQuery Query;
    ContourRequest Request;
    std::size_t Triangles = 0; ///< of the surface that was extracted, on this rank
    bool SizeAccepted = false;
    bool Direct = false;                      ///< whether the final level follows the first one
    std::shared_ptr<FinishedLayers> Finished; ///< that make a surface of a sample exact; or null
    std::shared_ptr<const void> AreShown;     ///< null before any of them is extracted
    std::int64_t FinishedSlices = 0;          ///< that this surface has of them
    Clock::time_point GrowthBegin;            ///< when extracting it began
    Clock::time_point GrowthDue;              ///< before which the next one does not begin
    bool HasGrown = false;                    ///< whether GrowthDue is to be found
    bool GrowthEnded = false;                 ///< whether an extraction has failed on any rank
    std::string Sampled; ///< the volume until whose finer surface this one may stay; or empty
    bool Stays = false;  ///< whether the surface of the pass before is shown
  };

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
  /// The finest level that this execution may extract. Collective.
  Result<int> ChoosePassLevel(const ExtractionTask& task, const std::string& sampled);
  /// Has the surface of a sample stay until there is a finer one, if this pass, whose level is the first
  /// one, is of the file that it is a sample of. Collective.
  Status KeepSurface(const ExtractionTask& task, const Pass& before);
  /// The level that follows the last one.
  int GetLevelAfterPass(const BlockedVolume& volume);
  /// Whether the last surface, of a volume or of images, can be refined; the same on all ranks.
  /// Collective.
  bool MayRefine(Communicator& ranks, bool& ofImages);
  /// Whether the last surface is of a sample at its finest level, and may have exact parts.
  bool MayGrow() const;
  /// PrepareRefinement of such a surface: with more of what is exact. Collective.
  Refinement PrepareGrowth(Communicator& ranks, double seconds);
  /// Begins to extract that, if it is time for it. Collective.
  Refinement BeginGrowth(Communicator& ranks);
  /// How many slices of what is finished it is to have, and its triangles. Collective.
  std::int64_t ChooseFinishedSlices(
    Communicator& ranks, std::int64_t finished, Refinement& refinement) const;
  /// Whether it is time for so many, and there is memory. Collective.
  bool IsGrowthDue(Communicator& ranks, std::int64_t slices, Refinement& refinement);
  /// Begins to extract a finer surface, unless it is too large. Collective.
  Status BeginRefinement(Communicator& ranks, Refinement& refinement);
  /// Begins to extract it, which takes memory and a thread; this rank alone.
  Status Prepare(
    const std::shared_ptr<BlockedVolume>& volume, int level, std::int64_t finishedSlices);
  /// What the next level takes, and the finest level that fits into memory. Collective.
  Status FindFittingLevel(Communicator& ranks, BlockedVolume& volume, Refinement& refinement);
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
  VolumeContour OfVolumes;
  Pass LastPass;
  Refinement LastRefinement; ///< of the last surface
  bool CoarseAllowed = false;
  int RanksOnNode = 0; ///< 0: not known yet
};

} // namespace isosurface

#endif
