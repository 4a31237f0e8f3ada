// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkStabbingContour.h"

#include "ArrayRanges.h"
#include "ChosenScalars.h"
#include "ContourBlocks.h"
#include "CostFieldData.h"
#include "ImageContour.h"
#include "ImagePieces.h"
#include "Query/QueryCost.h"
#include "Query/VolumeContour.h"
#include "SurfacePolyData.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationStabbingRequestKey.h"
#include "vtkStabbingRequest.h"

#include "vtkAlgorithmOutput.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkExecutive.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMath.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPlane.h"
#include "vtkPlanes.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Base/ParallelFor.h"
#include "Contour/SurfaceExtractor.h"
#include "ControllerCommunicator.h"
#include "Query/LevelChoice.h"
#include "Query/ProgressiveLevels.h"
#include "Store/BlockedVolume.h"
#include "Volume/BlockSelection.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkStabbingContour);
vtkCxxSetObjectMacro(vtkStabbingContour, Controller, vtkMultiProcessController);
vtkCxxSetObjectMacro(vtkStabbingContour, Frustum, vtkPlanes);

using isosurface::BlockedVolume;
using isosurface::ContourRequest;
using isosurface::LevelChoice;
using isosurface::QueryCost;
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;
using isosurface::SurfaceQuery;

namespace
{

// Whether a request set in this input information reaches a blocked volume's reader.
bool IsBehindReader(vtkInformation* info)
{
  if (vtkBlockedVolumeReader::BLOCKED_VOLUME()->Has(info))
  {
    return true;
  }
  if (!vtkInformationStabbingRequestKey::IsTransparent(info))
  {
    return false;
  }
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(info);
  return executive->GetNumberOfInputPorts() > 0 && executive->GetNumberOfInputConnections(0) > 0 &&
    IsBehindReader(executive->GetInputInformation(0, 0));
}

} // namespace

struct vtkStabbingContour::Output : isosurface::VolumeContour::Outcome
{
  std::vector<isosurface::InterpolatedArray> Arrays; ///< of the surface's attributes
  std::string ArrayName;                             ///< of the contoured array
  bool Final = true;
};

/**
 * What the last execution was made of. It goes on with the same surface if neither this filter, nor
 * the volume, nor the time step has changed.
 */
struct vtkStabbingContour::Pass
{
  int Level = 0;
  bool Shown = false;    ///< whether the surface of this level was extracted
  vtkMTimeType Time = 0; ///< of the filter
  std::weak_ptr<isosurface::BlockedVolume> Volume;
  std::size_t TimeStep = 0;

  bool IsOf(vtkMTimeType time, const std::shared_ptr<isosurface::BlockedVolume>& volume,
    std::size_t step) const
  {
    return this->Time == time && this->Volume.lock() == volume && this->TimeStep == step;
  }
};

//------------------------------------------------------------------------------
vtkStabbingContour::vtkStabbingContour()
  : Component(0)
  , ComputeNormals(1)
  , ComputeScalars(1)
  , GenerateTriangles(1)
  , Level(0)
  , TimeBudget(0)
  , MaximumTriangles(0)
  , Progressive(0)
  , Final(1)
  , DropDegenerateTriangles(0)
  , CloseBoundary(0)
  , UseRegion(0)
  , RegionPosition{ 0, 0, 0 }
  , RegionLength{ 1, 1, 1 }
  , Frustum(nullptr)
  , NumberOfThreads(0)
  , RanksOnNode(0)
  , Controller(nullptr)
  , OfImages(new isosurface::ImageContour)
  , OfVolumes(new isosurface::VolumeContour)
  , LastPass(new Pass)
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
  this->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
}

//------------------------------------------------------------------------------
vtkStabbingContour::~vtkStabbingContour()
{
  this->SetController(nullptr);
  this->SetFrustum(nullptr);
}

//------------------------------------------------------------------------------
void vtkStabbingContour::AddInterpolatedArray(const char* name)
{
  if (name && *name &&
    std::find(this->InterpolatedArrays.begin(), this->InterpolatedArrays.end(), name) ==
      this->InterpolatedArrays.end())
  {
    this->InterpolatedArrays.emplace_back(name);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkStabbingContour::RemoveAllInterpolatedArrays()
{
  if (!this->InterpolatedArrays.empty())
  {
    this->InterpolatedArrays.clear();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
int vtkStabbingContour::GetNumberOfInterpolatedArrays()
{
  return static_cast<int>(this->InterpolatedArrays.size());
}

//------------------------------------------------------------------------------
const char* vtkStabbingContour::GetInterpolatedArray(int index)
{
  return index >= 0 && index < this->GetNumberOfInterpolatedArrays()
    ? this->InterpolatedArrays[static_cast<std::size_t>(index)].c_str()
    : nullptr;
}

//------------------------------------------------------------------------------
void vtkStabbingContour::SetRegionBounds(const double bounds[6])
{
  this->SetRegionPosition(bounds[0], bounds[2], bounds[4]);
  this->SetRegionLength(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]);
}

//------------------------------------------------------------------------------
void vtkStabbingContour::SetFrustumPlanes(const double planes[24])
{
  if (std::all_of(planes, planes + 24, [](double coefficient) { return coefficient == 0; }))
  {
    this->SetFrustum(nullptr);
    return;
  }
  double copy[24];
  std::copy(planes, planes + 24, copy);
  vtkNew<vtkPlanes> frustum;
  frustum->SetFrustumPlanes(copy);
  this->SetFrustum(frustum);
}

//------------------------------------------------------------------------------
isosurface::Region vtkStabbingContour::MakeRegion()
{
  isosurface::Region region;
  if (this->UseRegion)
  {
    std::array<double, 6> bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds[2 * axis] = this->RegionPosition[axis];
      bounds[2 * axis + 1] = this->RegionPosition[axis] + this->RegionLength[axis];
    }
    region = isosurface::Region::FromBounds(bounds);
  }
  std::vector<isosurface::HalfSpace> halfSpaces;
  vtkNew<vtkPlane> plane;
  for (int number = 0; this->Frustum && number < this->Frustum->GetNumberOfPlanes(); ++number)
  {
    this->Frustum->GetPlane(number, plane);
    isosurface::HalfSpace halfSpace;
    plane->GetNormal(halfSpace.Normal.data());
    halfSpace.Offset = vtkMath::Dot(plane->GetNormal(), plane->GetOrigin());
    halfSpaces.push_back(halfSpace);
  }
  return region.Intersect(isosurface::Region(halfSpaces));
}

//------------------------------------------------------------------------------
std::vector<std::string> vtkStabbingContour::ChooseInterpolatedArrays(const std::string& contoured)
{
  std::vector<std::string> names = this->InterpolatedArrays;
  if (this->ComputeScalars)
  {
    names.erase(std::remove(names.begin(), names.end(), contoured), names.end());
  }
  return names;
}

//------------------------------------------------------------------------------
vtkMTimeType vtkStabbingContour::GetMTime()
{
  const vtkMTimeType time = std::max(this->Superclass::GetMTime(), this->ContourValues->GetMTime());
  return this->Frustum ? std::max(time, this->Frustum->GetMTime()) : time;
}

//------------------------------------------------------------------------------
void vtkStabbingContour::Refine()
{
  Pass& pass = *this->LastPass;
  const std::shared_ptr<isosurface::BlockedVolume> volume = pass.Volume.lock();
  if (!this->Progressive || this->Final || !pass.Shown || pass.Time != this->GetMTime() || !volume)
  {
    return;
  }
  pass.Level = isosurface::GetNextLevel(*volume, pass.Level, this->Level);
  pass.Shown = false;
  this->Modified();
  pass.Time = this->GetMTime();
}

//------------------------------------------------------------------------------
int vtkStabbingContour::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

//------------------------------------------------------------------------------
std::string vtkStabbingContour::GetArrayToContour()
{
  vtkInformation* array = this->GetInputArrayInformation(0);
  return array->Has(vtkDataObject::FIELD_NAME()) ? array->Get(vtkDataObject::FIELD_NAME()) : "";
}

//------------------------------------------------------------------------------
int vtkStabbingContour::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  this->AskInput(input[0]->GetInformationObject(0), outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER()),
    outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  return 1;
}

//------------------------------------------------------------------------------
void vtkStabbingContour::AskInput(vtkInformation* inInfo, int piece, int pieces)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  inInfo->Set(Pipeline::UPDATE_PIECE_NUMBER(), piece);
  inInfo->Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), pieces);
  // Gradients at the border of a piece need one sample beyond it. Ghost levels that consumers ask
  // of the surface are not needed: its pieces fit by GlobalIds.
  inInfo->Set(
    Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), this->ComputeNormals && pieces > 1 ? 1 : 0);

  // A source that does not know the request would execute again for each one, and to no purpose.
  if (!IsBehindReader(inInfo))
  {
    return;
  }
  // Straight behind a reader the blocks are taken through the handle.
  vtkNew<vtkStabbingRequest> request;
  if (vtkBlockedVolumeReader::BLOCKED_VOLUME()->Has(inInfo))
  {
    request->SetHandleOnly(true);
  }
  else
  {
    const double* values = this->ContourValues->GetValues();
    request->SetArrayName(this->GetArrayToContour());
    request->SetComponent(this->Component);
    request->SetIsovalues(std::vector<double>(values, values + this->GetNumberOfContours()));
    request->SetLevel(this->Level);
    request->SetSelection(
      { this->CloseBoundary ? isosurface::GridSides::All() : isosurface::GridSides(),
        this->MakeRegion() });
  }
  vtkBlockedVolumeReader::STABBING_REQUEST()->Set(inInfo, request);
}

//------------------------------------------------------------------------------
int vtkStabbingContour::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  vtkInformation* outInfo = output->GetInformationObject(0);
  vtkPolyData* polyData = vtkPolyData::GetData(output, 0);
  vtkBlockedVolumeReader::STABBING_REQUEST()->Withdraw(inInfo);

  ContourRequest request;
  const double* values = this->ContourValues->GetValues();
  request.Isovalues.assign(values, values + this->GetNumberOfContours());
  request.Normals = this->ComputeNormals != 0;
  request.GlobalIds = true;
  request.Polygons = this->GenerateTriangles == 0;
  request.Offsets = true;
  request.DropDegenerateTriangles = this->DropDegenerateTriangles != 0;
  if (this->CloseBoundary)
  {
    request.ClosedSides = isosurface::GridSides::All();
  }

  isosurface::ControllerCommunicator ranks(this->Controller);
  if (this->RanksOnNode == 0)
  {
    this->RanksOnNode = ranks.GetRanksOnNode();
  }
  Output made;
  Status status = vtkBlockedVolumeReader::BLOCKED_VOLUME()->Has(inInfo)
    ? this->ExtractFromVolume(inInfo, outInfo, request, made)
    : this->ExtractFromImages(input, request, made);
  if (status.IsOk() && this->CheckAbort())
  {
    status = Status(StatusCode::Aborted, "The contour was stopped.");
  }
  status = ranks.Agree(status);
  this->Final = !status.IsOk() || made.Final;
  this->LastPass->Shown = status.IsOk();
  if (status.GetCode() == StatusCode::Aborted)
  {
    return 1;
  }
  if (!status.IsOk())
  {
    vtkErrorMacro(<< status.GetMessage());
    return 0;
  }

  QueryCost& cost = made.Cost;
  cost.Triangles = made.Extracted.NumberOfTriangles;
  cost.ExtractSeconds = made.Extracted.TotalSeconds;
  vtkLogF(INFO,
    "Stabbing Contour: rank %d: %llu tree pages read, %llu active blocks, %llu blocks and %llu "
    "bytes read, %llu cache hits, %llu triangles; query %.4f s, read %.4f s, extract %.4f s",
    ranks.GetRank(), static_cast<unsigned long long>(cost.Reading.TreePagesRead),
    static_cast<unsigned long long>(cost.Reading.ActiveBlocks),
    static_cast<unsigned long long>(cost.Reading.BlocksRead),
    static_cast<unsigned long long>(cost.Reading.BytesRead),
    static_cast<unsigned long long>(cost.Reading.BlockCacheHits),
    static_cast<unsigned long long>(cost.Triangles), cost.Reading.QuerySeconds,
    cost.Reading.ReadSeconds, cost.ExtractSeconds);
  isosurface::MoveToPolyData(
    made.Extracted, made.Arrays, this->ComputeScalars ? made.ArrayName : "", polyData);
  isosurface::StoreRanges(polyData, this->ChooseThreads());
  isosurface::AddCostToFieldData(ranks.GetRank(), cost, polyData);
  return 1;
}

//------------------------------------------------------------------------------
bool vtkStabbingContour::TellProgress(double share)
{
  this->UpdateProgress(share);
  return !this->CheckAbort();
}

//------------------------------------------------------------------------------
int vtkStabbingContour::ChooseThreads()
{
  return this->NumberOfThreads > 0 ? this->NumberOfThreads
                                   : isosurface::ChooseThreadCount(this->RanksOnNode);
}

//------------------------------------------------------------------------------
Result<int> vtkStabbingContour::ChoosePassLevel(
  const std::shared_ptr<BlockedVolume>& volume, const SurfaceQuery& query)
{
  const int finest = std::min(this->Level, volume->GetNumberOfLevels() - 1);
  if (!this->Progressive)
  {
    return finest;
  }
  isosurface::ControllerCommunicator ranks(this->Controller);
  Pass& pass = *this->LastPass;
  std::vector<std::uint64_t> isNew = { pass.IsOf(this->GetMTime(), volume, query.TimeStep) ? 0U
                                                                                           : 1U };
  ranks.ReduceMaximum(isNew);
  if (isNew.front() != 0)
  {
    const auto first = isosurface::ChooseFirstLevel(*volume, query, finest, ranks);
    if (!first.IsOk())
    {
      return first;
    }
    pass.Level = *first;
    pass.Time = this->GetMTime();
    pass.Volume = volume;
    pass.TimeStep = query.TimeStep;
  }
  return pass.Level;
}

//------------------------------------------------------------------------------
Status vtkStabbingContour::MakeQuery(
  const BlockedVolume& volume, const ContourRequest& request, SurfaceQuery& query, Output& output)
{
  const isosurface::BlockedVolumeHeader& header = volume.GetHeader();
  output.ArrayName = this->GetArrayToContour();
  // Without a choice: the first array, which the reader makes the active scalars.
  const auto array =
    output.ArrayName.empty() ? std::optional<std::size_t>(0) : header.FindArray(output.ArrayName);
  if (!array)
  {
    return Status(StatusCode::NotFound,
      volume.GetPath() + ": has no array \"" + output.ArrayName + "\" to contour");
  }
  output.ArrayName = header.Arrays[*array].Name;
  const auto variable = volume.GetVariables().FindChoice(*array, this->Component);
  if (!variable)
  {
    return isosurface::MakeComponentError(
      output.ArrayName, header.Arrays[*array].Components, this->Component);
  }
  query.Variable = *variable;
  for (const std::string& name : this->ChooseInterpolatedArrays(output.ArrayName))
  {
    const auto attribute = header.FindArray(name);
    if (!attribute)
    {
      return Status(
        StatusCode::NotFound, volume.GetPath() + ": has no array \"" + name + "\" to interpolate");
    }
    const isosurface::ArrayDescription& description = header.Arrays[*attribute];
    query.Attributes.push_back(*attribute);
    output.Arrays.push_back({ name, {}, { description.Type, description.Components } });
  }
  query.Isovalues = request.Isovalues;
  query.Selection = { request.ClosedSides, this->MakeRegion() };
  return Status::Ok();
}

//------------------------------------------------------------------------------
Status vtkStabbingContour::ExtractFromVolume(
  vtkInformation* inInfo, vtkInformation* outInfo, ContourRequest& request, Output& output)
{
  auto* handle =
    static_cast<vtkBlockedVolumeHandle*>(vtkBlockedVolumeReader::BLOCKED_VOLUME()->Get(inInfo));
  const std::shared_ptr<BlockedVolume> volume = handle->GetVolume();
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  SurfaceQuery query;
  query.TimeStep = handle->FindTimeStep(inInfo);
  query.Rank = outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER());
  query.Ranks = std::max(1, outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  const Status status = this->MakeQuery(*volume, request, query, output);
  for (const isosurface::InterpolatedArray& array : output.Arrays)
  {
    request.Attributes.push_back(array.Layout);
  }
  const isosurface::ExtractionBudget budget = { this->TimeBudget,
    static_cast<std::uint64_t>(this->MaximumTriangles) };
  isosurface::ControllerCommunicator ranks(this->Controller);
  if (this->Progressive || budget.IsLimited())
  {
    // What follows is collective.
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  }
  ISOSURFACE_RETURN_IF_ERROR(status);
  const auto finest = this->ChoosePassLevel(volume, query);
  if (!finest.IsOk())
  {
    return finest.GetStatus();
  }
  output.Final = *finest <= this->Level;
  const isosurface::VolumeContour::Task task = { *volume, query, request, this->ChooseThreads(),
    [this](double share) { return this->TellProgress(share); } };
  if (budget.IsLimited())
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->OfVolumes->ExtractWithinBudget(ranks, budget, task, *finest, output));
    // What forbids this level forbids finer ones, too.
    output.Final = output.Final || output.Cost.Level > *finest;
    return Status::Ok();
  }
  LevelChoice choice;
  choice.Level = *finest;
  return this->OfVolumes->ExtractAtLevel(task, choice, output);
}

//------------------------------------------------------------------------------
Result<isosurface::ImagePieces> vtkStabbingContour::CollectPieces(
  isosurface::Communicator& ranks, vtkInformation* inInfo, Output& output)
{
  auto findArray = [&](vtkImageData* image) -> Result<vtkDataArray*>
  {
    int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
    vtkDataArray* array = this->GetInputArrayToProcess(0, image, association);
    if (array && association != vtkDataObject::FIELD_ASSOCIATION_POINTS)
    {
      return Status(StatusCode::InvalidArgument,
        std::string("array \"") + (array->GetName() ? array->GetName() : "") +
          "\" is not a point array; convert it to point data first");
    }
    if (array && array->GetName())
    {
      output.ArrayName = array->GetName();
    }
    if (array && !isosurface::FindChosenComponent(array->GetNumberOfComponents(), this->Component))
    {
      return isosurface::MakeComponentError(
        output.ArrayName, array->GetNumberOfComponents(), this->Component);
    }
    return array;
  };
  auto pieces =
    isosurface::CollectImagePieces(ranks, vtkDataObject::GetData(inInfo), inInfo, findArray);
  if (!pieces.IsOk())
  {
    const std::string name = this->GetArrayToContour();
    return pieces.GetStatus().GetCode() == StatusCode::NotFound
      ? Status(StatusCode::NotFound, "the input has no point array \"" + name + "\" to contour")
      : pieces.GetStatus();
  }
  return pieces;
}

//------------------------------------------------------------------------------
Status vtkStabbingContour::ExtractFromImages(
  vtkInformationVector** input, ContourRequest& request, Output& output)
{
  isosurface::ControllerCommunicator ranks(this->Controller);
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  output.Cost.Level = IsBehindReader(inInfo) ? this->Level : 0;
  const auto pieces = this->CollectPieces(ranks, inInfo, output);
  if (!pieces.IsOk())
  {
    return pieces.GetStatus();
  }

  auto extracted = this->OfImages->Extract(*pieces,
    { this->Component, this->ChooseInterpolatedArrays(output.ArrayName), this->MakeRegion(),
      this->ChooseThreads() },
    request, [this](double share) { return this->TellProgress(share); });
  if (!extracted.IsOk())
  {
    return extracted.GetStatus();
  }
  output.Extracted = std::move(extracted->Extracted);
  output.Arrays = std::move(extracted->Arrays);
  output.Cost.Reading.ActiveBlocks += extracted->ActiveBlocks;
  return Status::Ok();
}

//------------------------------------------------------------------------------
vtkStabbingContour* vtkStabbingContour::FindBehind(vtkAlgorithmOutput* connection)
{
  vtkAlgorithm* producer = connection ? connection->GetProducer() : nullptr;
  while (producer && producer->GetNumberOfInputConnections(0) > 0 &&
    (producer->IsA("vtkPVPostFilter") || producer->IsA("vtkPassThrough")))
  {
    producer = producer->GetInputAlgorithm(0, 0);
  }
  return vtkStabbingContour::SafeDownCast(producer);
}

//------------------------------------------------------------------------------
Status vtkStabbingContour::CollectBlocks(
  int piece, int pieces, const std::optional<double>& time, isosurface::ContourBlocks& blocks)
{
  isosurface::ControllerCommunicator ranks(this->Controller);
  if (this->RanksOnNode == 0)
  {
    this->RanksOnNode = ranks.GetRanksOnNode();
  }
  const double* values = this->ContourValues->GetValues();
  blocks.Isovalues.assign(values, values + this->GetNumberOfContours());
  vtkAlgorithmOutput* connection = this->GetInputConnection(0, 0);
  bool isUpdated = false;
  if (connection)
  {
    this->UpdateInformation();
    vtkInformation* inInfo = this->GetInputInformation();
    this->AskInput(inInfo, piece, pieces);
    if (time)
    {
      inInfo->Set(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP(), *time);
    }
    isUpdated = connection->GetProducer()->GetExecutive()->Update(connection->GetIndex()) != 0;
    vtkBlockedVolumeReader::STABBING_REQUEST()->Withdraw(inInfo);
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(isUpdated
      ? Status::Ok()
      : Status(StatusCode::InvalidArgument, "the contour filter has no input, or it failed")));
  vtkInformation* inInfo = this->GetInputInformation();
  return vtkBlockedVolumeReader::BLOCKED_VOLUME()->Has(inInfo)
    ? this->CollectBlocksOfVolume(ranks, inInfo, piece, pieces, blocks)
    : this->CollectBlocksOfImages(ranks, inInfo, blocks);
}

//------------------------------------------------------------------------------
Status vtkStabbingContour::CollectBlocksOfVolume(isosurface::Communicator& ranks,
  vtkInformation* inInfo, int piece, int pieces, isosurface::ContourBlocks& blocks)
{
  auto* handle =
    static_cast<vtkBlockedVolumeHandle*>(vtkBlockedVolumeReader::BLOCKED_VOLUME()->Get(inInfo));
  const std::shared_ptr<BlockedVolume> volume = handle->GetVolume();
  SurfaceQuery query;
  query.TimeStep = handle->FindTimeStep(inInfo);
  query.Rank = piece;
  query.Ranks = pieces;
  ContourRequest request;
  request.Isovalues = blocks.Isovalues;
  Output output;
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->MakeQuery(*volume, request, query, output)));
  blocks.ArrayName = output.ArrayName;
  isosurface::VolumeBlocksQuery wanted;
  if (blocks.Attributes)
  {
    blocks.Arrays = output.Arrays;
    wanted.Attributes = query.Attributes;
  }
  wanted.Level = std::min(this->Level, volume->GetNumberOfLevels() - 1);
  if (this->MaximumTriangles > 0)
  {
    isosurface::QueryStatistics statistics;
    const auto choice = isosurface::ChooseLevel(*volume, query, wanted.Level,
      { 0, static_cast<std::uint64_t>(this->MaximumTriangles) }, this->OfVolumes->GetRate(), ranks,
      statistics);
    ISOSURFACE_RETURN_IF_ERROR(choice.GetStatus());
    wanted.Level = choice->Level;
  }
  wanted.TimeStep = query.TimeStep;
  wanted.Variable = query.Variable;
  wanted.Region = query.Selection.Region;
  wanted.Rank = piece;
  wanted.Ranks = pieces;
  return ranks.Agree(isosurface::CollectVolumeBlocks(volume, wanted, blocks));
}

//------------------------------------------------------------------------------
Status vtkStabbingContour::CollectBlocksOfImages(
  isosurface::Communicator& ranks, vtkInformation* inInfo, isosurface::ContourBlocks& blocks)
{
  Output output;
  auto collected = this->CollectPieces(ranks, inInfo, output);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(collected.GetStatus()));
  auto pieces = std::make_shared<isosurface::ImagePieces>(std::move(*collected));
  std::vector<isosurface::ChosenScalars> scalars;
  std::vector<isosurface::PieceAttributes> attributes;
  Status status;
  for (const isosurface::ImagePiece& piece : pieces->Pieces)
  {
    auto found = isosurface::FindAttributes(piece,
      blocks.Attributes ? this->ChooseInterpolatedArrays(output.ArrayName)
                        : std::vector<std::string>());
    if (!found.IsOk())
    {
      status = found.GetStatus();
      break;
    }
    output.Arrays = found->Arrays;
    attributes.push_back(std::move(*found));
    scalars.emplace_back(piece.Samples,
      *isosurface::FindChosenComponent(
        static_cast<int>(piece.Samples.Components.size()), this->Component),
      this->ChooseThreads());
  }
  vtkInformation* data = vtkDataObject::GetData(inInfo)->GetInformation();
  if (data->Has(vtkDataObject::DATA_TIME_STEP()))
  {
    blocks.Time = data->Get(vtkDataObject::DATA_TIME_STEP());
  }
  blocks.ArrayName = output.ArrayName;
  blocks.Arrays = output.Arrays;
  return isosurface::CollectImageBlocks(ranks, status, pieces, std::move(scalars),
    std::move(attributes), this->MakeRegion(), this->ChooseThreads(), blocks);
}

//------------------------------------------------------------------------------
void vtkStabbingContour::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ContourValues:\n";
  this->ContourValues->PrintSelf(os, indent.GetNextIndent());
  os << indent << "Component: " << this->Component << "\n";
  os << indent << "ComputeNormals: " << this->ComputeNormals << "\n";
  os << indent << "ComputeScalars: " << this->ComputeScalars << "\n";
  os << indent << "GenerateTriangles: " << this->GenerateTriangles << "\n";
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "TimeBudget: " << this->TimeBudget << "\n";
  os << indent << "MaximumTriangles: " << this->MaximumTriangles << "\n";
  os << indent << "InterpolatedArrays:";
  for (const std::string& name : this->InterpolatedArrays)
  {
    os << " \"" << name << "\"";
  }
  os << "\n";
  os << indent << "DropDegenerateTriangles: " << this->DropDegenerateTriangles << "\n";
  os << indent << "CloseBoundary: " << this->CloseBoundary << "\n";
  os << indent << "UseRegion: " << this->UseRegion << "\n";
  os << indent << "RegionPosition: " << this->RegionPosition[0] << " " << this->RegionPosition[1]
     << " " << this->RegionPosition[2] << "\n";
  os << indent << "RegionLength: " << this->RegionLength[0] << " " << this->RegionLength[1] << " "
     << this->RegionLength[2] << "\n";
  os << indent << "Frustum: " << this->Frustum << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
