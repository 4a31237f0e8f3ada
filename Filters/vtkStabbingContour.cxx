// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkStabbingContour.h"

#include "ArrayRanges.h"
#include "ContourExecution.h"
#include "ErrorReport.h"
#include "ImagePieces.h"
#include "PassingFilters.h"
#include "SurfaceFieldData.h"
#include "SurfacePolyData.h"

#include "vtkAlgorithmOutput.h"
#include "vtkDataObject.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPlanes.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

vtkStandardNewMacro(vtkStabbingContour);
vtkCxxSetObjectMacro(vtkStabbingContour, Controller, vtkMultiProcessController);
vtkCxxSetObjectMacro(vtkStabbingContour, Frustum, vtkPlanes);

using isosurface::ContourExecution;
using isosurface::Status;
using isosurface::StatusCode;

namespace
{

void LogCost(int rank, const isosurface::QueryCost& cost)
{
  const isosurface::QueryStatistics& reading = cost.Reading;
  vtkLogF(1,
    "Stabbing Contour: rank %d: %llu tree pages read, %llu active blocks, %llu blocks and %llu "
    "bytes read, %llu cache hits, %llu triangles; query %.4f s, read %.4f s, extract %.4f s",
    rank, static_cast<unsigned long long>(reading.TreePagesRead),
    static_cast<unsigned long long>(reading.ActiveBlocks),
    static_cast<unsigned long long>(reading.BlocksRead),
    static_cast<unsigned long long>(reading.BytesRead),
    static_cast<unsigned long long>(reading.BlockCacheHits),
    static_cast<unsigned long long>(cost.Triangles), reading.QuerySeconds, reading.ReadSeconds,
    cost.ExtractSeconds);
}

void FillOutput(vtkStabbingContour& contour, int rank, int threads,
  isosurface::ContourOutcome& made, vtkPolyData* output)
{
  made.Cost.Triangles = made.Extracted.NumberOfTriangles;
  made.Cost.ExtractSeconds = made.Extracted.TotalSeconds;
  isosurface::MoveToPolyData(
    made.Extracted, made.Arrays, contour.GetComputeScalars() ? made.ArrayName : "", output);
  isosurface::AddBlocks(made.Blocks, output);
  isosurface::StoreRanges(output, threads);
  isosurface::AddCostToFieldData(rank, made.Cost, output);
  if (made.Islands)
  {
    isosurface::AddIslands(
      *made.Islands, contour.GetComputeIslandIds() != 0, made.IslandSeconds, output);
  }
}

} // namespace

vtkStabbingContour::vtkStabbingContour()
  : Refinement(isosurface::Refinement().ToValues())
  , Work(new ContourExecution(*this))
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
  this->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS_THEN_CELLS, vtkDataSetAttributes::SCALARS);
}

vtkStabbingContour::~vtkStabbingContour()
{
  this->SetController(nullptr);
  this->SetFrustum(nullptr);
}

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

void vtkStabbingContour::RemoveAllInterpolatedArrays()
{
  if (!this->InterpolatedArrays.empty())
  {
    this->InterpolatedArrays.clear();
    this->Modified();
  }
}

int vtkStabbingContour::GetNumberOfInterpolatedArrays()
{
  return static_cast<int>(this->InterpolatedArrays.size());
}

const char* vtkStabbingContour::GetInterpolatedArray(int index)
{
  return index >= 0 && index < this->GetNumberOfInterpolatedArrays()
    ? this->InterpolatedArrays[static_cast<std::size_t>(index)].c_str()
    : nullptr;
}

void vtkStabbingContour::SetSkipNaN(vtkTypeBool skip)
{
  if (this->SkipNaN != skip)
  {
    this->SkipNaN = skip;
    this->SetSkipNotANumber(skip);
  }
}

void vtkStabbingContour::SetRegionBounds(const double bounds[6])
{
  this->SetRegionPosition(bounds[0], bounds[2], bounds[4]);
  this->SetRegionLength(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]);
}

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

vtkMTimeType vtkStabbingContour::GetMTime()
{
  const vtkMTimeType time = std::max(this->Superclass::GetMTime(), this->ContourValues->GetMTime());
  return this->Frustum ? std::max(time, this->Frustum->GetMTime()) : time;
}

void vtkStabbingContour::Refine()
{
  if (this->Work->GetSurfaces().Refine(this->GetMTime()))
  {
    this->Modified();
    this->Work->GetSurfaces().KeepChange(this->GetMTime());
  }
}

int* vtkStabbingContour::GetLevelRange()
{
  vtkAlgorithmOutput* input =
    this->GetNumberOfInputConnections(0) > 0 ? this->GetInputConnection(0, 0) : nullptr;
  vtkInformation* info =
    input ? input->GetProducer()->GetOutputInformation(input->GetIndex()) : nullptr;
  const auto volume = info ? isosurface::VolumeInput(info).GetVolume() : nullptr;
  this->LevelRange[1] = volume ? volume->GetNumberOfLevels() - 1 : 0;
  return this->LevelRange;
}

void vtkStabbingContour::AllowCoarse(vtkTypeBool allowed)
{
  this->Work->AllowCoarse(allowed != 0);
}

void vtkStabbingContour::PrepareRefinement(int milliseconds)
{
  isosurface::ControllerCommunicator ranks(this->Controller);
  this->Refinement = this->Work->GetSurfaces()
                       .Prepare(ranks, std::max(0, milliseconds) / 1000.0, this->GetMTime())
                       .ToValues();
}

void vtkStabbingContour::DropRefinement()
{
  this->Work->GetSurfaces().DropPrepared();
}

void vtkStabbingContour::AcceptSize()
{
  this->Work->GetSurfaces().AcceptSize();
}

bool vtkStabbingContour::FindsIslands()
{
  return this->MinimumIslandSize > 0 || this->MaximumIslands > 0 || this->UseIslandPoint ||
    this->ComputeIslandIds;
}

void vtkStabbingContour::SetRefinementMemory(double mebibytes)
{
  // The surface does not depend on it, so it does not modify the filter.
  this->RefinementMemory = mebibytes;
}

int vtkStabbingContour::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

int vtkStabbingContour::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  this->Work->ReleaseImages();
  // RequestData is not called behind a failure.
  this->IslandSummary.clear();
  this->AskInput(input[0]->GetInformationObject(0), outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER()),
    outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  return 1;
}

void vtkStabbingContour::AskInput(vtkInformation* inInfo, int piece, int pieces)
{
  // Gradients at the border of a piece need one sample beyond it, and samples that are averages of
  // cells need one cell more. Ghost levels that consumers ask of the surface are not needed: its
  // pieces fit by GlobalIds.
  const int levels = (this->ComputeNormals ? 1 : 0) + (this->TakesCells(inInfo) ? 1 : 0);
  isosurface::AskVolume(*this, inInfo, piece, pieces, pieces > 1 ? levels : 0);
}

bool vtkStabbingContour::TakesCells(vtkInformation* inInfo)
{
  return isosurface::IsCellArrayChosen(this->GetInputArrayInformation(0), inInfo) ||
    std::any_of(this->InterpolatedArrays.begin(), this->InterpolatedArrays.end(),
      [inInfo](const std::string& name)
      {
        return vtkDataObject::GetNamedFieldInformation(
                 inInfo, vtkDataObject::FIELD_ASSOCIATION_CELLS, name.c_str()) != nullptr;
      });
}

const char* vtkStabbingContour::GetUnit()
{
  this->Unit = isosurface::FindContouredUnit(
    this->GetNumberOfInputConnections(0) > 0 ? this->GetInputDataObject(0, 0) : nullptr,
    [this](vtkDataSet* data) { return this->GetInputArrayToProcess(0, data); });
  return this->Unit.c_str();
}

void vtkStabbingContour::SetInputArrayToProcess(
  int index, int port, int connection, int association, const char* name)
{
  if (association != vtkDataObject::FIELD_ASSOCIATION_ROWS)
  {
    this->Superclass::SetInputArrayToProcess(index, port, connection, association, name);
  }
}

int vtkStabbingContour::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  vtkPolyData* polyData = vtkPolyData::GetData(output, 0);
  isosurface::ReleaseVolume(*this, inInfo);
  const vtkSmartPointer<vtkPolyData> last = std::move(this->LastSurface);

  isosurface::ControllerCommunicator ranks(this->Controller);
  isosurface::ContourOutcome made;
  Status status = isosurface::RunCollective(isosurface::NotExtracted,
    [&] { return this->Work->Extract(inInfo, output->GetInformationObject(0), made); });
  if (status.IsOk())
  {
    status = isosurface::Attempt(isosurface::NotExtracted,
      [&]
      {
        if (made.Stays)
        {
          polyData->ShallowCopy(last);
        }
        else
        {
          FillOutput(*this, ranks.GetRank(), this->Work->ChooseThreads(), made, polyData);
        }
        if (made.Stays || made.MayStay)
        {
          this->LastSurface = vtkSmartPointer<vtkPolyData>::New();
          this->LastSurface->ShallowCopy(polyData);
        }
        return Status::Ok();
      });
  }
  if (isosurface::IsAborted(*this))
  {
    // Outweighs an error, such as that of a reader that was stopped before it had a volume.
    status = Status(StatusCode::Aborted, "The contour was aborted.");
  }
  status = ranks.Agree(status);
  this->Final = this->Work->SetShown(status.IsOk(), made);
  const double* isovalues = this->ContourValues->GetValues();
  this->IslandSummary = !status.IsOk() || !made.Islands
    ? ""
    : isosurface::SummariseIslands(
        *made.Islands, { isovalues, isovalues + this->ContourValues->GetNumberOfContours() });
  if (!status.IsOk())
  {
    polyData->Initialize();
    return isosurface::EndExecution(this, output, status);
  }
  if (made.Stays)
  {
    vtkLogF(1, "Stabbing Contour: rank %d: the surface of the sample stays", ranks.GetRank());
  }
  else
  {
    LogCost(ranks.GetRank(), made.Cost);
  }
  return 1;
}

vtkStabbingContour* vtkStabbingContour::FindBehind(vtkAlgorithmOutput* connection)
{
  vtkAlgorithm* producer = connection ? connection->GetProducer() : nullptr;
  while (producer && isosurface::FindPassedArrays(producer) == isosurface::PassedArrays::All &&
    producer->GetNumberOfInputConnections(0) > 0)
  {
    producer = producer->GetInputAlgorithm(0, 0);
  }
  return vtkStabbingContour::SafeDownCast(producer);
}

void vtkStabbingContour::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ContourValues:\n";
  this->ContourValues->PrintSelf(os, indent.GetNextIndent());
  this->VisitProperties(
    [&](const char* name, auto value) { os << indent << name << ": " << value << "\n"; });
  os << indent << "Final: " << this->Final << "\n";
  os << indent << "Refinement:";
  for (const double number : this->Refinement)
  {
    os << " " << number;
  }
  os << "\n";
  os << indent << "RefinementMemory: " << this->RefinementMemory << "\n";
  os << indent << "InterpolatedArrays:";
  for (const std::string& name : this->InterpolatedArrays)
  {
    os << " \"" << name << "\"";
  }
  os << "\n";
  os << indent << "UseRegion: " << this->UseRegion << "\n";
  os << indent << "RegionPosition: " << this->RegionPosition[0] << " " << this->RegionPosition[1]
     << " " << this->RegionPosition[2] << "\n";
  os << indent << "RegionLength: " << this->RegionLength[0] << " " << this->RegionLength[1] << " "
     << this->RegionLength[2] << "\n";
  os << indent << "Frustum: " << this->Frustum << "\n";
  os << indent << "IslandPoint: " << this->IslandPoint[0] << " " << this->IslandPoint[1] << " "
     << this->IslandPoint[2] << "\n";
  os << indent << "IslandSummary: " << this->IslandSummary << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
