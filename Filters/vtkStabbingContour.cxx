// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkStabbingContour.h"

#include "ArrayRanges.h"
#include "ContourExecution.h"
#include "ErrorReport.h"
#include "ImagePieces.h"
#include "PassingFilters.h"
#include "RangedArray.h"
#include "SurfacePolyData.h"

#include "vtkAlgorithmOutput.h"
#include "vtkCellData.h"
#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPlanes.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"

#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

vtkStandardNewMacro(vtkStabbingContour);
vtkCxxSetObjectMacro(vtkStabbingContour, Controller, vtkMultiProcessController);
vtkCxxSetObjectMacro(vtkStabbingContour, Frustum, vtkPlanes);

using namespace isosurface;

namespace
{

void LogCost(int rank, const QueryCost& cost)
{
  const QueryStatistics& reading = cost.Reading;
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

/// Adds what the query cost this rank to the output's field data, one array of one value a quantity. Written as a
/// table, the ranks' values are its rows. Of a level that was chosen within a budget also EstimatedTriangles,
/// PredictedSeconds, and LevelLimit, the name of the property that limits it, or nothing.
void AddQueryCost(int rank, const QueryCost& cost, vtkPolyData* output)
{
  const auto add = [output](const char* name, auto value) { AddToFieldData(output, name, value); };
  add("Rank", rank);
  add("TreePagesRead", cost.Reading.TreePagesRead);
  add("DirectoryPagesRead", cost.Reading.DirectoryPagesRead);
  add("ActiveBlocks", cost.Reading.ActiveBlocks);
  add("BlocksRead", cost.Reading.BlocksRead);
  add("BytesRead", cost.Reading.BytesRead);
  add("BlockCacheHits", cost.Reading.BlockCacheHits);
  add("Triangles", cost.Triangles);
  add("Level", cost.Level);
  add("QuerySeconds", cost.Reading.QuerySeconds);
  add("ReadSeconds", cost.Reading.ReadSeconds);
  add("ExtractSeconds", cost.ExtractSeconds);
  if (!cost.Choice)
  {
    return;
  }
  add("EstimatedTriangles", cost.Choice->Triangles);
  add("PredictedSeconds", cost.Choice->Seconds);
  vtkNew<vtkStringArray> limit;
  limit->SetName("LevelLimit");
  limit->InsertNextValue(cost.Choice->Limit == LevelLimit::Triangles ? "MaximumTriangles"
      : cost.Choice->Limit == LevelLimit::Seconds                    ? "TimeBudget"
                                                                     : "");
  output->GetFieldData()->AddArray(limit);
}

/// Adds to a surface which block of a composite each of its points is of: the point array BlockIds, and the field
/// array BlockNames, which has the name of each number. Nothing for a single block.
void AddBlocks(const std::vector<std::int32_t>& blocks, const std::vector<std::string>& names,
  vtkPolyData* surface)
{
  const vtkSmartPointer<vtkDataArray> ids = surface->GetPointData()->GetGlobalIds();
  if (names.empty() || !ids)
  {
    return;
  }
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("BlockIds");
  numbers->SetNumberOfTuples(static_cast<vtkIdType>(blocks.size()));
  std::copy(blocks.begin(), blocks.end(), numbers->GetPointer(0));
  // Ids stay the last array: see MoveToPolyData.
  surface->GetPointData()->RemoveArray(ids->GetName());
  surface->GetPointData()->AddArray(numbers);
  surface->GetPointData()->SetGlobalIds(ids);
  vtkNew<vtkStringArray> column;
  column->SetName("BlockNames");
  for (const std::string& name : names)
  {
    column->InsertNextValue(name);
  }
  surface->GetFieldData()->AddArray(column);
}

/// Adds what was found to the output's field data (see SetMinimumIslandSize), and the ids of the cells, if there are
/// any, whose memory the output takes.
void AddIslands(ChosenIslands& islands, bool ids, double seconds, vtkPolyData* output)
{
  const auto add = [output](const char* name, const auto& rows, const auto member)
  {
    using Value = std::decay_t<decltype(rows.front().*member)>;
    std::vector<double> values;
    for (const auto& row : rows)
    {
      values.push_back(static_cast<double>(row.*member));
    }
    output->GetFieldData()->AddArray(
      MakeColumn(name, std::is_floating_point_v<Value> ? VTK_DOUBLE : VTK_ID_TYPE, values));
  };
  add("Islands", islands.OfIsovalues, &IsovalueIslands::Islands);
  add("KeptIslands", islands.OfIsovalues, &IsovalueIslands::KeptIslands);
  AddToFieldData(output, "IslandSeconds", seconds);
  add("IslandTriangles", islands.Largest, &ListedIsland::Triangles);
  add("IslandArea", islands.Largest, &ListedIsland::Area);
  add("IslandVolume", islands.Largest, &ListedIsland::Volume);
  add("IslandBinSize", islands.Bins, &IslandBin::Size);
  add("IslandBinIslands", islands.Bins, &IslandBin::Islands);
  add("IslandBinTriangles", islands.Bins, &IslandBin::Triangles);
  if (ids)
  {
    static_assert(sizeof(vtkIdType) == sizeof(std::int64_t), "ids have 64 bits");
    vtkNew<vtkIdTypeArray> ofCells;
    ofCells->SetName("IslandId");
    const auto cells = static_cast<vtkIdType>(islands.Ids.GetSize());
    AdoptMemory(ofCells, islands.Ids.Release(), cells);
    output->GetCellData()->AddArray(ofCells);
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
  return std::max({ this->Superclass::GetMTime(), this->ContourValues->GetMTime(),
    this->Frustum ? this->Frustum->GetMTime() : 0 });
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
  const auto volume = this->GetNumberOfInputConnections(0) > 0
    ? VolumeInput(this->GetInputInformation()).GetVolume()
    : nullptr;
  this->LevelRange[1] = volume ? volume->GetNumberOfLevels() - 1 : 0;
  return this->LevelRange;
}

void vtkStabbingContour::AllowCoarse(vtkTypeBool allowed)
{
  this->Work->AllowCoarse(allowed != 0);
}

void vtkStabbingContour::PrepareRefinement(int milliseconds)
{
  ControllerCommunicator ranks(this->Controller);
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
  AskVolume(*this, inInfo, piece, pieces, pieces > 1 ? levels : 0);
}

bool vtkStabbingContour::TakesCells(vtkInformation* inInfo)
{
  return IsCellArrayChosen(*this, inInfo) ||
    std::any_of(this->InterpolatedArrays.begin(), this->InterpolatedArrays.end(),
      [inInfo](const std::string& name)
      {
        return vtkDataObject::GetNamedFieldInformation(
                 inInfo, vtkDataObject::FIELD_ASSOCIATION_CELLS, name.c_str()) != nullptr;
      });
}

const char* vtkStabbingContour::GetUnit()
{
  this->Unit = FindContouredUnit(*this);
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
  ReleaseVolume(*this, inInfo);
  const vtkSmartPointer<vtkPolyData> last = std::move(this->LastSurface);

  ControllerCommunicator ranks(this->Controller);
  ContourRun made;
  const auto fill = [&]
  {
    if (made.Stays)
    {
      polyData->ShallowCopy(last);
    }
    else
    {
      made.Cost.Triangles = made.Extracted.NumberOfTriangles;
      made.Cost.ExtractSeconds = made.Extracted.TotalSeconds;
      MoveToPolyData(
        made.Extracted, made.Arrays, this->ComputeScalars ? made.ArrayName : "", polyData);
      AddBlocks(made.Blocks, made.BlockNames, polyData);
      StoreRanges(polyData, this->Work->ChooseThreads());
      AddQueryCost(ranks.GetRank(), made.Cost, polyData);
      if (made.Request.Islands)
      {
        AddIslands(made.Islands, made.Request.Islands->Ids, made.IslandSeconds, polyData);
      }
    }
    if (made.Stays || made.MayStay)
    {
      this->LastSurface = vtkSmartPointer<vtkPolyData>::New();
      this->LastSurface->ShallowCopy(polyData);
    }
    return Status::Ok();
  };
  Status status = RunCollective(NotExtracted,
    [&] { return this->Work->Extract(inInfo, output->GetInformationObject(0), made); });
  status = status.IsOk() ? Attempt(NotExtracted, fill) : status;
  status = AgreeOnEnd(*this, ranks, status);
  this->Final = this->Work->SetShown(status.IsOk(), made);
  this->IslandSummary = status.IsOk() && made.Request.Islands
    ? SummariseIslands(made.Islands, made.Request.Isovalues)
    : "";
  if (status.IsOk() && made.Stays)
  {
    vtkLogF(1, "Stabbing Contour: rank %d: the surface of the sample stays", ranks.GetRank());
  }
  else if (status.IsOk())
  {
    LogCost(ranks.GetRank(), made.Cost);
  }
  return EndExecution(this, output, status);
}

vtkStabbingContour* vtkStabbingContour::FindBehind(vtkAlgorithmOutput* connection)
{
  vtkAlgorithm* producer = connection ? connection->GetProducer() : nullptr;
  while (producer && FindPassedArrays(producer) == PassedArrays::All &&
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
  const auto print = [&](const char* name, const auto& values)
  {
    os << indent << name << ":";
    for (const auto& value : values)
    {
      os << " " << value;
    }
    os << "\n";
  };
  os << indent << "Final: " << this->Final << "\n";
  print("Refinement", this->Refinement);
  os << indent << "RefinementMemory: " << this->RefinementMemory << "\n";
  print("InterpolatedArrays", this->InterpolatedArrays);
  os << indent << "UseRegion: " << this->UseRegion << "\n";
  print("RegionPosition", this->RegionPosition);
  print("RegionLength", this->RegionLength);
  os << indent << "Frustum: " << this->Frustum << "\n";
  print("IslandPoint", this->IslandPoint);
  os << indent << "IslandSummary: " << this->IslandSummary << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
