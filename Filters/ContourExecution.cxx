// SPDX-License-Identifier: BSD-3-Clause
#include "ContourExecution.h"

#include "ErrorReport.h"
#include "MatchVTK.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkStabbingContour.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPlane.h"
#include "vtkPlanes.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Ground/Base/AvailableMemory.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/Stopwatch.h"
#include "Ground/Volume/BlockSelection.h"
#include "Ranks/Query/ContourBlocks.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/SurfaceMemory.h"
#include "Ranks/Sharing/StoreRecovery.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

namespace isosurface
{

namespace
{
using Pipeline = vtkStreamingDemandDrivenPipeline;

Status CheckIslands(const IslandRequest& request)
{
  const auto isFinite = [](double coordinate) { return std::isfinite(coordinate); };
  if (std::isnan(request.MinimumSize))
  {
    return { StatusCode::InvalidArgument, "MinimumIslandSize is not a number" };
  }
  return request.Place && !std::all_of(request.Place->begin(), request.Place->end(), isFinite)
    ? Status(StatusCode::InvalidArgument, "IslandPoint is not a place")
    : Status::Ok();
}

PointPrecision ToPointPrecision(int precision)
{
  return precision == vtkAlgorithm::SINGLE_PRECISION ? PointPrecision::Single
    : precision == vtkAlgorithm::DOUBLE_PRECISION    ? PointPrecision::Double
                                                     : PointPrecision::Default;
}
}

ContourExecution::ContourExecution(vtkStabbingContour& contour)
  : Contour(contour)
  , Surfaces([this] { return this->FindFreeMemory(); })
{
}

ContourExecution& ContourExecution::Of(vtkStabbingContour& contour)
{
  return *contour.Work;
}

//------------------------------------------------------------------------------
// What the properties mean

ControllerCommunicator ContourExecution::GetRanks()
{
  return ControllerCommunicator(this->Contour.GetController());
}

int ContourExecution::ChooseThreads()
{
  if (this->RanksOnNode == 0)
  {
    this->RanksOnNode = this->GetRanks().GetRanksOnNode();
  }
  const int threads = this->Contour.GetNumberOfThreads();
  return threads > 0 ? threads : ChooseThreadCount(this->RanksOnNode);
}

ContourRequest ContourExecution::MakeRequest()
{
  ContourRequest request;
  for (vtkIdType n = 0; n < this->Contour.GetNumberOfContours(); ++n)
  {
    request.Isovalues.push_back(this->Contour.GetValue(static_cast<int>(n)));
  }
  request.Normals = this->Contour.GetComputeNormals() != 0;
  isosurface::MatchVTK(request);
  request.Precision = ToPointPrecision(this->Contour.GetOutputPointsPrecision());
  request.GlobalIds = true;
  request.Polygons = this->Contour.GetGenerateTriangles() == 0;
  request.Offsets = true;
  request.SkipNotANumber = this->Contour.GetSkipNotANumber() != 0;
  request.DropDegenerateTriangles = this->Contour.GetDropDegenerateTriangles() != 0;
  if (this->Contour.GetCloseBoundary())
  {
    request.ClosedSides = GridSides::All();
    request.ClosedSides.AreBeyondInside = this->Contour.GetInside() == vtkStabbingContour::BELOW;
    request.DropDegenerateTriangles = true; // caps meet in triangles without area
  }
  return request;
}

Region ContourExecution::MakeRegion()
{
  Region region;
  if (this->Contour.GetUseRegion())
  {
    const double* position = this->Contour.GetRegionPosition();
    const double* length = this->Contour.GetRegionLength();
    std::array<double, 6> bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds[2 * axis] = position[axis];
      bounds[2 * axis + 1] = position[axis] + length[axis];
    }
    region = Region::FromBounds(bounds);
  }
  std::vector<HalfSpace> halfSpaces;
  vtkPlanes* frustum = this->Contour.GetFrustum();
  vtkNew<vtkPlane> plane;
  for (int number = 0; frustum && number < frustum->GetNumberOfPlanes(); ++number)
  {
    frustum->GetPlane(number, plane);
    HalfSpace halfSpace;
    plane->GetNormal(halfSpace.Normal.data());
    halfSpace.Offset = vtkMath::Dot(plane->GetNormal(), plane->GetOrigin());
    halfSpaces.push_back(halfSpace);
  }
  return region.Intersect(Region(halfSpaces));
}

IslandRequest ContourExecution::MakeIslandRequest(int level)
{
  IslandRequest request;
  switch (this->Contour.GetIslandSize())
  {
    case vtkStabbingContour::AREA:
      request.Size = IslandSize::Area;
      break;
    case vtkStabbingContour::VOLUME:
      request.Size = IslandSize::Volume;
      break;
    default:
      request.Size = IslandSize::Triangles;
  }
  request.MinimumSize = this->Contour.GetMinimumIslandSize();
  request.MaximumIslands = static_cast<std::uint64_t>(this->Contour.GetMaximumIslands());
  if (this->Contour.GetUseIslandPoint())
  {
    const double* point = this->Contour.GetIslandPoint();
    request.Place = { point[0], point[1], point[2] };
  }
  request.Ids = this->Contour.GetComputeIslandIds() != 0;
  request.Level = level;
  return request;
}

std::string ContourExecution::GetArrayToContour()
{
  vtkInformation* array = this->Contour.GetInputArrayInformation(0);
  return array->Has(vtkDataObject::FIELD_NAME()) ? array->Get(vtkDataObject::FIELD_NAME()) : "";
}

std::vector<std::string> ContourExecution::ChooseInterpolatedArrays(const std::string& contoured)
{
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(this->Contour.GetNumberOfInterpolatedArrays()));
  for (int n = 0; n < this->Contour.GetNumberOfInterpolatedArrays(); ++n)
  {
    names.emplace_back(this->Contour.GetInterpolatedArray(n));
  }
  if (this->Contour.GetComputeScalars())
  {
    names.erase(std::remove(names.begin(), names.end(), contoured), names.end());
  }
  return names;
}

//------------------------------------------------------------------------------
// A surface

Status ContourExecution::Extract(
  vtkInformation* inInfo, vtkInformation* outInfo, ContourOutcome& outcome)
{
  const VolumeInput input(inInfo);
  ControllerCommunicator ranks = this->GetRanks();
  SurfaceQuery query;
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOnQuery(input, ranks, query, outcome, nullptr));
  return input ? this->ExtractFromVolume(input, query, outInfo, outcome)
               : this->ExtractFromImages(inInfo, outcome);
}

Status ContourExecution::AgreeOnQuery(const VolumeInput& input, Communicator& ranks,
  SurfaceQuery& query, ContourOutcome& outcome, const ContourBlocks* blocks)
{
  std::uint64_t fingerprint = 0;
  const auto make = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(input.GetStatus());
    ISOSURFACE_RETURN_IF_ERROR(CheckIslands(this->MakeIslandRequest(0)));
    const Status made = input ? this->MakeQuery(input, query, outcome) : Status::Ok();
    fingerprint = this->ComputeFingerprint(query, blocks);
    return made;
  };
  const Status status = Attempt(NotExtracted, make);
  std::vector<CommonValue> values = input.MakeCommonValues();
  values.push_back({ fingerprint,
    "the properties of the contour filter, or of the one that takes its blocks, are not the same "
    "on all ranks" });
  return ranks.Agree(status, values);
}

std::uint64_t ContourExecution::ComputeFingerprint(
  const SurfaceQuery& query, const ContourBlocks* blocks)
{
  vtkStabbingContour& contour = this->Contour;
  Fingerprint fingerprint;
  fingerprint.AddText(this->GetArrayToContour());
  const int arrays = contour.GetNumberOfInterpolatedArrays();
  for (int n = 0; n < arrays; ++n)
  {
    fingerprint.AddText(contour.GetInterpolatedArray(n));
  }
  fingerprint.AddReals(this->MakeRequest().Isovalues);
  const Region region = this->MakeRegion();
  for (const HalfSpace& halfSpace : region.GetHalfSpaces())
  {
    fingerprint.AddReals(halfSpace.Normal);
    fingerprint.AddReal(halfSpace.Offset);
  }
  contour.VisitProperties(
    [&fingerprint](const char*, auto value)
    {
      if constexpr (std::is_floating_point_v<decltype(value)>)
      {
        fingerprint.AddReal(value);
      }
      else
      {
        fingerprint.AddNumber(static_cast<std::uint64_t>(value));
      }
    });
  const double* point = contour.GetIslandPoint();
  fingerprint.AddReals(std::array<double, 3>{ point[0], point[1], point[2] });
  for (const int number : { arrays, static_cast<int>(query.Variable),
         contour.GetInputArrayInformation(0)->Get(vtkDataObject::FIELD_ASSOCIATION()),
         this->CoarseAllowed ? 1 : 0, blocks && blocks->Normals ? 1 : 0,
         blocks && blocks->Attributes ? 1 : 0 })
  {
    fingerprint.AddNumber(static_cast<std::uint64_t>(number));
  }
  return fingerprint.Get();
}

Status ContourExecution::MakeQuery(
  const VolumeInput& input, SurfaceQuery& query, ContourOutcome& outcome)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto variable,
    input.FindVariable(this->GetArrayToContour(), this->Contour.GetComponent()));
  const std::shared_ptr<BlockedVolume> volume = input.GetVolume();
  const std::vector<ArrayDescription>& arrays = volume->GetHeader().Arrays;
  query.TimeStep = input.GetTimeStep();
  query.Variable = variable;
  outcome.ArrayName = arrays[volume->GetVariables()[variable].Array].Name;
  for (const std::string& name : this->ChooseInterpolatedArrays(outcome.ArrayName))
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto attribute, input.FindArray(name, "interpolate"));
    query.Attributes.push_back(attribute);
    outcome.Arrays.push_back(
      { name, {}, { arrays[attribute].Type, arrays[attribute].Components } });
  }
  const ContourRequest request = this->MakeRequest();
  query.Isovalues = request.Isovalues;
  query.Selection = { request.ClosedSides, this->MakeRegion() };
  return Status::Ok();
}

Status ContourExecution::ExtractFromVolume(const VolumeInput& input, const SurfaceQuery& agreed,
  vtkInformation* outInfo, ContourOutcome& outcome)
{
  ControllerCommunicator ranks = this->GetRanks();
  ExtractionTask task = { input.GetVolume(), agreed, this->MakeRequest(), this->ChooseThreads(),
    isosurface::MakeProgress(this->Contour), this->Contour.GetDynamicBalance() ? &ranks : nullptr };
  task.Query.Rank = outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER());
  task.Query.Ranks = std::max(1, outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  task.Request.Attributes = GetLayouts(outcome.Arrays);
  std::string warning;
  const Status status = RunWithReplicas(
    ranks, [&] { return task.Volume.get(); }, warning,
    [&] { return this->ExtractOnce(input, task, outcome); });
  ReportWarning(&this->Contour, ranks, status, warning);
  return this->ChooseIslands(
    ranks, status, [&] { return MakeIslandGrids(task, outcome.Cost.Level, ranks); }, outcome);
}

Status ContourExecution::ChooseIslands(Communicator& ranks, const Status& extracted,
  const std::function<IslandGrids()>& makeGrids, ContourOutcome& outcome)
{
  outcome.ExtractedTriangles = outcome.Extracted.NumberOfTriangles;
  if (!this->Contour.FindsIslands())
  {
    return extracted;
  }
  outcome.Islands.emplace();
  const Stopwatch stopwatch(outcome.IslandSeconds);
  return isosurface::ChooseIslands(ranks, extracted, this->MakeIslandRequest(outcome.Cost.Level),
    makeGrids, this->ChooseThreads(), outcome.Extracted, *outcome.Islands);
}

/// Says so before the first rank extracts more than it has memory for. In the window, a question
/// stands in front of such a surface.
void ContourExecution::WarnOfLackOfMemory(const ExtractionTask& task, int level)
{
  constexpr double mebiByte = 1 << 20;
  const auto free = static_cast<double>(this->FindFreeMemory());
  if (task.Query.Rank != 0 || this->Contour.GetProgressive() || free <= 0 ||
    !task.Query.Selection.Region.GetHalfSpaces().empty())
  {
    return;
  }
  double triangles = 0;
  const auto estimate = [&]
  {
    const auto all = EstimateTriangles(*task.Volume, task.Query, level);
    triangles = all.IsOk() ? *all : 0;
    return all.GetStatus();
  };
  // What is wrong with the volume is told by all ranks, when they extract the surface.
  static_cast<void>(Attempt("", estimate));
  const double bytes = triangles / task.Query.Ranks * EstimateBytesPerTriangle(task.Request);
  if (bytes > UsableMemoryShare * free)
  {
    vtkWarningWithObjectMacro(&this->Contour,
      "The surface has about "
        << std::llround(triangles) << " triangles, which need " << std::llround(bytes / mebiByte)
        << " MiB of memory on a rank, and " << std::llround(free / mebiByte)
        << " MiB are free. MaximumTriangles, Level or UseRegion make it smaller.");
  }
}

RefinementRequest ContourExecution::MakeRefinementRequest()
{
  RefinementRequest wanted;
  wanted.MayBeCoarse = this->CoarseAllowed;
  wanted.FindsIslands = this->Contour.FindsIslands();
  wanted.Change = this->Contour.GetMTime();
  return wanted;
}

Status ContourExecution::ExtractOnce(
  const VolumeInput& input, const ExtractionTask& task, ContourOutcome& outcome)
{
  ControllerCommunicator ranks = this->GetRanks();
  const ExtractionBudget budget = { this->Contour.GetTimeBudget(),
    static_cast<std::uint64_t>(this->Contour.GetMaximumTriangles()) };
  RefinementRequest wanted = this->MakeRefinementRequest();
  wanted.Level = this->Contour.GetLevel();
  wanted.IsProgressive = this->Contour.GetProgressive() != 0;
  this->InMemory.Release();
  this->Stored.Ask(task, budget, input.GetHandle().GetFinished(), input.GetHandle().GetSampled());
  ISOSURFACE_ASSIGN_OR_RETURN(const auto choice, this->Surfaces.Begin(ranks, this->Stored, wanted));
  outcome.MayStay = choice.MayStay;
  outcome.Stays = choice.Stays;
  outcome.Cost.Level = choice.Level;
  if (outcome.Stays)
  {
    return Status::Ok();
  }
  if (!budget.IsLimited())
  {
    this->WarnOfLackOfMemory(task, choice.Level);
  }
  return this->Stored.Extract(ranks, choice.Level, outcome);
}

Status ContourExecution::ExtractFromImages(vtkInformation* inInfo, ContourOutcome& outcome)
{
  ControllerCommunicator ranks = this->GetRanks();
  ImagePieces pieces;
  const auto ask = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto query, this->CollectImages(ranks, inInfo, true, pieces, outcome));
    this->Averages.DropUnused();
    this->InMemory.Ask(std::move(query), isosurface::MakeProgress(this->Contour));
    return Status::Ok();
  };
  const Status asked = ask();
  const auto choice =
    this->Surfaces.Begin(ranks, this->InMemory, this->MakeRefinementRequest(), asked);
  Status status = choice.GetStatus();
  if (status.IsOk()) // on all ranks
  {
    status = this->ChooseIslands(
      ranks, this->InMemory.Extract(ranks, choice->Level, outcome),
      [&] { return this->InMemory.MakeQuery(choice->Level).MakeIslandGrids(ranks); }, outcome);
  }
  if (status.IsOk() && pieces.BlockNames.size() > 1)
  {
    status = Attempt(NotExtracted,
      [&]
      {
        outcome.Blocks = { this->InMemory.MakeQuery(choice->Level).FindFirstIds(), pieces.Blocks,
          pieces.BlockNames };
        return Status::Ok();
      });
  }
  if (!status.IsOk() || choice->IsFinal)
  {
    this->InMemory.Release();
  }
  return status;
}

Result<MemoryQuery> ContourExecution::CollectImages(Communicator& ranks, vtkInformation* inInfo,
  bool interpolates, ImagePieces& pieces, ContourOutcome& outcome)
{
  MemoryQuery query;
  query.Component = this->Contour.GetComponent();
  query.Threads = this->ChooseThreads();
  const auto choose = [&](vtkImageData* image, int& association)
  {
    vtkDataArray* array = this->Contour.GetInputArrayToProcess(0, image, association);
    if (array && array->GetName())
    {
      outcome.ArrayName = array->GetName();
    }
    return array;
  };
  ISOSURFACE_ASSIGN_OR_RETURN(pieces,
    CollectContouredPieces(ranks, inInfo, choose, this->GetArrayToContour(), query.Component,
      this->Averages, query.Threads));
  const auto add = [&]() -> Status
  {
    if (interpolates)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(outcome.Arrays,
        AddAttributes(pieces, this->ChooseInterpolatedArrays(outcome.ArrayName), this->Averages,
          query.Threads));
    }
    query.Samples = pieces;
    query.Region = this->MakeRegion();
    query.Request = this->MakeRequest();
    query.Request.Attributes = GetLayouts(outcome.Arrays);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(Attempt("the images of the input cannot be contoured", add));
  return query;
}

//------------------------------------------------------------------------------
// Finer surfaces

bool ContourExecution::SetShown(bool shown, const ContourOutcome& made)
{
  this->Surfaces.SetShown(shown, made.Cost.Level, made.ExtractedTriangles);
  return !shown || this->Surfaces.IsFinal();
}

std::uint64_t ContourExecution::FindFreeMemory()
{
  constexpr double mebiByte = 1 << 20;
  const double limit = this->Contour.GetRefinementMemory() * mebiByte;
  return limit > 0
    ? static_cast<std::uint64_t>(limit)
    : GetAvailableMemory() / static_cast<std::uint64_t>(std::max(1, this->RanksOnNode));
}

} // namespace isosurface
