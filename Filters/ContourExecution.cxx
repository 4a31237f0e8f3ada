// SPDX-License-Identifier: BSD-3-Clause
#include "ContourExecution.h"

#include "ErrorReport.h"
#include "MatchVTK.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkStabbingContour.h"

#include "vtkAlgorithmOutput.h"
#include "vtkDataObject.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkPlane.h"
#include "vtkPlanes.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Coding/BlockCoding/EdgeIndexProfile.h"
#include "Ground/Base/AvailableMemory.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/ParallelFor.h"
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

constexpr double MebiByte = 1 << 20;

Region MakeRegion(vtkStabbingContour& contour)
{
  Region region;
  if (contour.GetUseRegion())
  {
    const double* low = contour.GetRegionPosition();
    const double* length = contour.GetRegionLength();
    region = Region::FromBounds(
      { low[0], low[0] + length[0], low[1], low[1] + length[1], low[2], low[2] + length[2] });
  }
  std::vector<HalfSpace> halfSpaces;
  vtkPlanes* frustum = contour.GetFrustum();
  vtkNew<vtkPlane> plane;
  for (int number = 0; frustum && number < frustum->GetNumberOfPlanes(); ++number)
  {
    frustum->GetPlane(number, plane);
    HalfSpace& halfSpace = halfSpaces.emplace_back();
    plane->GetNormal(halfSpace.Normal.data());
    halfSpace.Offset = vtkMath::Dot(plane->GetNormal(), plane->GetOrigin());
  }
  return region.Intersect(Region(halfSpaces));
}

} // namespace

ContourExecution::ContourExecution(vtkStabbingContour& contour)
  : Contour(contour)
  , Surfaces([this] { return this->FindFreeMemory(); })
{
}

int ContourExecution::ChooseThreads()
{
  if (this->RanksOnNode == 0)
  {
    this->RanksOnNode = ControllerCommunicator(this->Contour.GetController()).GetRanksOnNode();
  }
  const int threads = this->Contour.GetNumberOfThreads();
  return threads > 0 ? threads : ChooseThreadCount(this->RanksOnNode);
}

//------------------------------------------------------------------------------
// What the properties mean

SurfaceRequest ContourExecution::MakeRequest()
{
  vtkStabbingContour& contour = this->Contour;
  SurfaceRequest request;
  for (int n = 0; n < contour.GetNumberOfContours(); ++n)
  {
    request.Isovalues.push_back(contour.GetValue(n));
  }
  request.Normals = contour.GetComputeNormals() != 0;
  isosurface::MatchVTK(request);
  const int precision = contour.GetOutputPointsPrecision();
  request.Precision = precision == vtkAlgorithm::SINGLE_PRECISION ? PointPrecision::Single
    : precision == vtkAlgorithm::DOUBLE_PRECISION                 ? PointPrecision::Double
                                                                  : PointPrecision::Default;
  request.GlobalIds = true;
  request.Polygons = contour.GetGenerateTriangles() == 0;
  request.Offsets = true;
  request.SkipNotANumber = contour.GetSkipNotANumber() != 0;
  request.DropDegenerateTriangles = contour.GetDropDegenerateTriangles() != 0;
  if (contour.GetCloseBoundary())
  {
    request.Close(contour.GetInside() == vtkStabbingContour::BELOW);
  }
  request.Where = MakeRegion(contour);
  request.Budget = { contour.GetTimeBudget(),
    static_cast<std::uint64_t>(contour.GetMaximumTriangles()) };
  if (contour.FindsIslands())
  {
    IslandRequest& islands = request.Islands.emplace();
    islands.Size = static_cast<IslandSize>(contour.GetIslandSize());
    islands.MinimumSize = contour.GetMinimumIslandSize();
    islands.MaximumIslands = static_cast<std::uint64_t>(contour.GetMaximumIslands());
    islands.Ids = contour.GetComputeIslandIds() != 0;
    if (contour.GetUseIslandPoint())
    {
      contour.GetIslandPoint(islands.Place.emplace().data());
    }
  }
  return request;
}

std::vector<std::string> ContourExecution::ChooseInterpolatedArrays(
  const std::string& contoured, const BlockArrays* blocks)
{
  std::vector<std::string> names;
  const int arrays =
    blocks && !blocks->Attributes ? 0 : this->Contour.GetNumberOfInterpolatedArrays();
  for (int n = 0; n < arrays; ++n)
  {
    const char* name = this->Contour.GetInterpolatedArray(n);
    if (!this->Contour.GetComputeScalars() || name != contoured)
    {
      names.emplace_back(name);
    }
  }
  return names;
}

Status ContourExecution::AgreeOnQuery(
  const VolumeInput& input, Communicator& ranks, const BlockArrays* blocks, ContourRun& run)
{
  std::uint64_t fingerprint = 0;
  const auto make = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(input.GetStatus());
    const double* point = this->Contour.GetIslandPoint();
    const char* const fault = std::isnan(this->Contour.GetMinimumIslandSize())
      ? "MinimumIslandSize is not a number"
      : this->Contour.GetUseIslandPoint() &&
        !std::all_of(point, point + 3, [](double coordinate) { return std::isfinite(coordinate); })
      ? "IslandPoint is not a place"
      : nullptr;
    if (fault)
    {
      return { StatusCode::InvalidArgument, fault };
    }
    run.Request = this->MakeRequest();
    const Status made = input ? this->MakeQuery(input, blocks, run) : Status::Ok();
    fingerprint = this->ComputeFingerprint(run, blocks);
    return made;
  };
  const Status status = Attempt(NotExtracted, make);
  std::vector<CommonValue> values = input.MakeCommonValues();
  values.push_back({ fingerprint,
    "the properties of the contour filter, or of the one that takes its blocks, are not the same "
    "on all ranks" });
  return ranks.Agree(status, values);
}

std::uint64_t ContourExecution::ComputeFingerprint(const ContourRun& run, const BlockArrays* blocks)
{
  vtkStabbingContour& contour = this->Contour;
  Fingerprint fingerprint;
  fingerprint.AddText(FindContouredName(contour));
  const int arrays = contour.GetNumberOfInterpolatedArrays();
  for (int n = 0; n < arrays; ++n)
  {
    fingerprint.AddText(contour.GetInterpolatedArray(n));
  }
  fingerprint.AddReals(run.Request.Isovalues);
  for (const HalfSpace& halfSpace : run.Request.Where.GetHalfSpaces())
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
  for (const int number : { arrays, static_cast<int>(run.Query.Variable),
         contour.GetInputArrayInformation(0)->Get(vtkDataObject::FIELD_ASSOCIATION()),
         this->CoarseAllowed ? 1 : 0, blocks && blocks->Normals ? 1 : 0,
         blocks && blocks->Attributes ? 1 : 0 })
  {
    fingerprint.AddNumber(static_cast<std::uint64_t>(number));
  }
  return fingerprint.Get();
}

Status ContourExecution::MakeQuery(
  const VolumeInput& input, const BlockArrays* blocks, ContourRun& run)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto variable,
    input.FindVariable(FindContouredName(this->Contour), this->Contour.GetComponent()));
  const std::shared_ptr<BlockedVolume> volume = input.GetVolume();
  const std::vector<ArrayDescription>& arrays = volume->GetHeader().Arrays;
  run.ArrayName = arrays[volume->GetVariables()[variable].Array].Name;
  for (const std::string& name : this->ChooseInterpolatedArrays(run.ArrayName, blocks))
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto array, input.FindArray(name, "interpolate"));
    run.Request.Arrays.push_back(array);
    run.Arrays.push_back({ name, {}, { arrays[array].Type, arrays[array].Components } });
  }
  run.Request.Attributes = GetLayouts(run.Arrays);
  run.Query = run.Request.MakeQuery(input.GetTimeStep(), variable);
  return Status::Ok();
}

//------------------------------------------------------------------------------
// A surface

Status ContourExecution::Extract(vtkInformation* inInfo, vtkInformation* outInfo, ContourRun& run)
{
  const VolumeInput input(inInfo);
  ControllerCommunicator ranks(this->Contour.GetController());
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOnQuery(input, ranks, nullptr, run));
  return input ? this->ExtractFromVolume(input, ranks, outInfo, run)
               : this->ExtractFromImages(inInfo, ranks, run);
}

Status ContourExecution::ExtractFromVolume(
  const VolumeInput& input, Communicator& ranks, vtkInformation* outInfo, ContourRun& run)
{
  ExtractionTask task = { input.GetVolume(), run.Query, run.Request, this->ChooseThreads(),
    isosurface::MakeProgress(this->Contour), this->Contour.GetDynamicBalance() ? &ranks : nullptr };
  task.Query.Rank = outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER());
  task.Query.Ranks = std::max(1, outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  std::string warning;
  const Status extracted = RunWithReplicas(
    ranks, [&] { return task.Volume.get(); }, warning,
    [&] { return this->ExtractOnce(input, ranks, task, run); });
  ReportWarning(&this->Contour, ranks, extracted, warning);
  return ChooseIslands(
    ranks, extracted, run.Request.Islands,
    [&] { return MakeIslandGrids(task, run.Cost.Level, ranks); }, task.Threads, run);
}

void ContourExecution::WarnOfLackOfMemory(const ExtractionTask& task, int level)
{
  const auto free = static_cast<double>(this->FindFreeMemory());
  if (task.Query.Rank != 0 || this->Contour.GetProgressive() || free <= 0 ||
    !task.Query.Selection.Region.IsEverything())
  {
    return;
  }
  // What is wrong with the volume is told by all ranks, when they extract the surface.
  const auto triangles =
    Attempt("", [&] { return EstimateTriangles(*task.Volume, task.Query, level); });
  const double bytes =
    !triangles.IsOk() ? 0 : *triangles / task.Query.Ranks * EstimateBytesPerTriangle(task.Request);
  if (bytes > UsableMemoryShare * free)
  {
    vtkWarningWithObjectMacro(&this->Contour,
      "The surface has about "
        << std::llround(*triangles) << " triangles, which need " << std::llround(bytes / MebiByte)
        << " MiB of memory on a rank, and " << std::llround(free / MebiByte)
        << " MiB are free. MaximumTriangles, Level or UseRegion make it smaller.");
  }
}

Status ContourExecution::ExtractOnce(
  const VolumeInput& input, Communicator& ranks, const ExtractionTask& task, ContourRun& run)
{
  const ExtractionBudget& budget = run.Request.Budget;
  const RefinementRequest wanted = { this->Contour.GetLevel(), this->Contour.GetProgressive() != 0,
    this->CoarseAllowed, run.Request.Islands.has_value(), this->Contour.GetMTime() };
  this->InMemory.Release();
  this->Stored.Ask(task, budget, input.GetHandle().GetFinished(), input.GetHandle().GetSampled());
  ISOSURFACE_ASSIGN_OR_RETURN(const auto choice, this->Surfaces.Begin(ranks, this->Stored, wanted));
  run.MayStay = choice.MayStay;
  run.Stays = choice.Stays;
  run.Cost.Level = choice.Level;
  if (run.Stays)
  {
    return Status::Ok();
  }
  if (!budget.IsLimited())
  {
    this->WarnOfLackOfMemory(task, choice.Level);
  }
  return this->Stored.Extract(ranks, choice.Level, run);
}

Status ContourExecution::ExtractFromImages(
  vtkInformation* inInfo, Communicator& ranks, ContourRun& run)
{
  ImagePieces pieces;
  const auto ask = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto query, this->CollectImages(ranks, inInfo, nullptr, pieces, run));
    this->Averages.DropUnused();
    this->InMemory.Ask(std::move(query), isosurface::MakeProgress(this->Contour));
    return Status::Ok();
  };
  const Status asked = ask();
  const auto choice = this->Surfaces.Begin(ranks, this->InMemory,
    { 0, false, this->CoarseAllowed, run.Request.Islands.has_value(), this->Contour.GetMTime() },
    asked);
  Status status = choice.GetStatus();
  const auto makeQuery = [&] { return this->InMemory.MakeQuery(choice->Level); };
  if (status.IsOk()) // on all ranks
  {
    status = ChooseIslands(
      ranks, this->InMemory.Extract(ranks, choice->Level, run), run.Request.Islands,
      [&] { return makeQuery().MakeIslandGrids(ranks); }, this->ChooseThreads(), run);
  }
  if (status.IsOk() && pieces.BlockNames.size() > 1)
  {
    status = Attempt(NotExtracted,
      [&]
      {
        run.Blocks = makeQuery().FindBlocks(run.Extracted, pieces.Blocks);
        run.BlockNames = pieces.BlockNames;
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
  const BlockArrays* blocks, ImagePieces& pieces, ContourRun& run)
{
  MemoryQuery query;
  query.Component = this->Contour.GetComponent();
  query.Threads = this->ChooseThreads();
  ISOSURFACE_ASSIGN_OR_RETURN(pieces,
    CollectContouredPieces(
      ranks, this->Contour, inInfo, query.Component, this->Averages, query.Threads));
  const auto add = [&]() -> Status
  {
    run.ArrayName = pieces.ArrayName;
    ISOSURFACE_ASSIGN_OR_RETURN(run.Arrays,
      AddAttributes(pieces, this->ChooseInterpolatedArrays(run.ArrayName, blocks), this->Averages,
        query.Threads));
    query.Samples = pieces;
    query.Region = run.Request.Where;
    query.Request = run.Request;
    query.Request.Attributes = GetLayouts(run.Arrays);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(Attempt("the images of the input cannot be contoured", add));
  return query;
}

bool ContourExecution::SetShown(bool shown, const ContourRun& made)
{
  this->Surfaces.SetShown(shown, made.Cost.Level, made.ExtractedTriangles);
  return !shown || this->Surfaces.IsFinal();
}

std::uint64_t ContourExecution::FindFreeMemory()
{
  const double limit = this->Contour.GetRefinementMemory() * MebiByte;
  return limit > 0
    ? static_cast<std::uint64_t>(limit)
    : GetAvailableMemory() / static_cast<std::uint64_t>(std::max(1, this->RanksOnNode));
}

//------------------------------------------------------------------------------
// The blocks of a surface

Status ContourExecution::TakeBlocks(vtkAlgorithm* consumer, vtkStabbingContour& contour,
  Communicator& ranks, const std::optional<double>& time, const BlockArrays& wanted,
  const std::function<Status(ContourBlocks&)>& take)
{
  ContourBlocks blocks;
  std::string warning;
  const Status status = RunWithReplicas(
    ranks, [&] { return blocks.Volume.get(); }, warning,
    [&]() -> Status
    {
      blocks = ContourBlocks();
      ISOSURFACE_RETURN_IF_ERROR(contour.Work->CollectBlocks(ranks, time, wanted, blocks));
      return take(blocks);
    });
  ReportWarning(consumer, ranks, status, warning);
  return status;
}

void SetProfile(vtkObject* consumer, int number, int& profile)
{
  const EdgeIndexProfile nearest = FindNearestProfile(number);
  if (number != static_cast<int>(nearest))
  {
    vtkWarningWithObjectMacro(consumer,
      "There is no profile " << number << " (1.0 had fast, 1, and compact, 2): "
                             << (nearest == EdgeIndexProfile::Small ? "small" : "working")
                             << " is used.");
  }
  if (profile != static_cast<int>(nearest))
  {
    profile = static_cast<int>(nearest);
    consumer->Modified();
  }
}

Status ContourExecution::CollectBlocks(const Communicator& consumers,
  const std::optional<double>& time, const BlockArrays& wanted, ContourBlocks& blocks)
{
  ControllerCommunicator ranks(this->Contour.GetController());
  // The input may be executed by all ranks together.
  const bool hasInput = this->Contour.GetNumberOfInputConnections(0) > 0;
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(hasInput ? Status::Ok()
                         : Status(StatusCode::InvalidArgument, "the contour filter has no input")));
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(this->UpdateInput(consumers.GetRank(), consumers.GetSize(), time)));
  vtkInformation* inInfo = this->Contour.GetInputInformation();
  const VolumeInput input(inInfo);
  ContourRun run;
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOnQuery(input, ranks, &wanted, run));
  blocks.Request = run.Request;
  blocks.Request.Normals = wanted.Normals;
  if (input)
  {
    // Before anything can fail, so that all ranks have it.
    blocks.Volume = input.GetVolume();
    blocks.ArrayName = run.ArrayName;
    blocks.Arrays = run.Arrays;
    run.Query.Rank = consumers.GetRank();
    run.Query.Ranks = consumers.GetSize();
    int level = std::min(this->Contour.GetLevel(), blocks.Volume->GetNumberOfLevels() - 1);
    if (run.Request.Budget.Triangles > 0)
    {
      QueryStatistics statistics;
      ISOSURFACE_ASSIGN_OR_RETURN(const auto choice,
        ChooseLevel(*blocks.Volume, run.Query, level, { 0, run.Request.Budget.Triangles },
          this->Stored.GetRate(), ranks, statistics));
      level = choice.Level;
    }
    return AttemptOnAll(ranks, NotExtracted,
      [&] { return CollectVolumeBlocks(blocks.Volume, run.Query, level, blocks); });
  }
  ImagePieces pieces;
  auto query = this->CollectImages(ranks, inInfo, &wanted, pieces, run);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(query.GetStatus()));
  vtkInformation* data = vtkDataObject::GetData(inInfo)->GetInformation();
  if (data->Has(vtkDataObject::DATA_TIME_STEP()))
  {
    blocks.Time = data->Get(vtkDataObject::DATA_TIME_STEP());
  }
  blocks.ArrayName = run.ArrayName;
  blocks.Arrays = run.Arrays;
  return CollectImageBlocks(ranks, std::move(*query), blocks);
}

Status ContourExecution::UpdateInput(int piece, int pieces, const std::optional<double>& time)
{
  vtkAlgorithmOutput* connection = this->Contour.GetInputConnection(0, 0);
  this->Contour.UpdateInformation();
  vtkInformation* inInfo = this->Contour.GetInputInformation();
  this->Contour.AskInput(inInfo, piece, pieces);
  if (time)
  {
    inInfo->Set(Pipeline::UPDATE_TIME_STEP(), *time);
  }
  const bool isUpdated =
    connection->GetProducer()->GetExecutive()->Update(connection->GetIndex()) != 0;
  ReleaseVolume(this->Contour, inInfo);
  if (!isUpdated)
  {
    return { StatusCode::InvalidArgument, "the input of the contour filter failed" };
  }
  return IsInputAborted(inInfo)
    ? Status(StatusCode::Aborted, "the input of the contour filter was aborted")
    : Status::Ok();
}

} // namespace isosurface
