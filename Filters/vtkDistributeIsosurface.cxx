// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkDistributeIsosurface.h"

#include "vtkBlockConsumerPipeline.h"
#include "vtkStabbingContour.h"

#include "vtkAlgorithmOutput.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ArrayRanges.h"
#include "Base/ParallelFor.h"
#include "ContourBlocks.h"
#include "ContourHeader.h"
#include "ControllerCommunicator.h"
#include "Redistribution/SurfaceExchange.h"
#include "SurfacePolyData.h"

#include <chrono>
#include <optional>
#include <type_traits>
#include <utility>

vtkStandardNewMacro(vtkDistributeIsosurface);
vtkCxxSetObjectMacro(vtkDistributeIsosurface, Controller, vtkMultiProcessController);

using isosurface::ContourBlocks;
using isosurface::EdgeIndexHeader;
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;
using isosurface::Surface;
using isosurface::SurfaceExchange;

namespace
{
using Pipeline = vtkStreamingDemandDrivenPipeline;

double GetSecondsSince(std::chrono::steady_clock::time_point begin)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

template <typename T>
void AddToFieldData(vtkPolyData* output, const char* name, T value)
{
  using Array = std::conditional_t<std::is_floating_point_v<T>, vtkDoubleArray, vtkIdTypeArray>;
  vtkNew<Array> array;
  array->SetName(name);
  array->InsertNextValue(static_cast<typename Array::ValueType>(value));
  output->GetFieldData()->AddArray(array);
}

void AddCost(int rank, const SurfaceExchange::Cost& cost, vtkPolyData* output)
{
  AddToFieldData(output, "Rank", rank);
  AddToFieldData(output, "ExtractedPoints", cost.EncodedPoints);
  AddToFieldData(output, "ReceivedPoints", cost.ReceivedPoints);
  AddToFieldData(output, "EncodedBytes", cost.EncodedBytes);
  AddToFieldData(output, "SentBytes", cost.SentBytes);
  AddToFieldData(output, "Rounds", cost.Rounds);
  AddToFieldData(output, "EncodeSeconds", cost.EncodeSeconds);
  AddToFieldData(output, "ChooseSeconds", cost.ChooseSeconds);
  AddToFieldData(output, "ExchangeSeconds", cost.ExchangeSeconds);
  AddToFieldData(output, "DecodeSeconds", cost.DecodeSeconds);
}

// The surface that is asked for of the blocks.
isosurface::ContourRequest MakeRequest(
  const EdgeIndexHeader& header, const ContourBlocks& blocks, bool polygons)
{
  isosurface::ContourRequest request;
  request.Isovalues = header.Isovalues;
  request.Normals = blocks.Normals;
  request.GlobalIds = true;
  request.Offsets = true;
  request.Polygons = polygons;
  for (const isosurface::InterpolatedArray& array : blocks.Arrays)
  {
    request.Attributes.push_back(array.Layout);
  }
  return request;
}

} // namespace

//------------------------------------------------------------------------------
vtkDistributeIsosurface::vtkDistributeIsosurface()
  : Mode(LOSSLESS)
  , MaximumError(0.05)
  , Profile(FAST)
  , NormalError(0.01)
  , ArrayError(0)
  , DrawingRanks(0)
  , RoundBytes(vtkIdType{ 4 } << 20)
  , NumberOfThreads(0)
  , Controller(nullptr)
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

//------------------------------------------------------------------------------
vtkDistributeIsosurface::~vtkDistributeIsosurface()
{
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
vtkExecutive* vtkDistributeIsosurface::CreateDefaultExecutive()
{
  return vtkBlockConsumerPipeline::New();
}

//------------------------------------------------------------------------------
bool vtkDistributeIsosurface::TakesBlocks() const
{
  return this->Controller && this->Controller->GetNumberOfProcesses() > 1;
}

//------------------------------------------------------------------------------
Status vtkDistributeIsosurface::CheckContour(vtkStabbingContour* contour) const
{
  const auto refuse = [](const char* reason)
  { return Status(StatusCode::InvalidArgument, reason); };
  if (!contour)
  {
    return refuse("What travels between ranks is where a surface crosses the grid of its volume, "
                  "which only the output of Stabbing Contour itself tells: put Distribute "
                  "Isosurface right behind it, and other filters behind Distribute Isosurface.");
  }
  if (contour->GetCloseBoundary())
  {
    return refuse("The caps that CloseBoundary adds cannot be distributed: turn CloseBoundary of "
                  "Stabbing Contour off.");
  }
  if (contour->GetDropDegenerateTriangles())
  {
    return refuse("A surface is distributed with all its triangles, and cannot do without those "
                  "that DropDegenerateTriangles leaves out: turn DropDegenerateTriangles of "
                  "Stabbing Contour off, or put Clean behind Distribute Isosurface.");
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
int vtkDistributeIsosurface::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkPolyData* polyData = vtkPolyData::GetData(output, 0);
  vtkStabbingContour* contour = vtkStabbingContour::FindBehind(this->GetInputConnection(0, 0));
  isosurface::ControllerCommunicator ranks(this->Controller);
  Status status = ranks.Agree(this->CheckContour(contour));
  if (status.IsOk() && !this->TakesBlocks())
  {
    polyData->ShallowCopy(vtkPolyData::GetData(input[0], 0));
    return 1;
  }
  if (status.IsOk())
  {
    status = this->Distribute(ranks, contour, output->GetInformationObject(0), polyData);
  }
  if (status.IsOk())
  {
    return 1;
  }
  polyData->Initialize();
  if (status.GetCode() == StatusCode::Aborted)
  {
    return 1;
  }
  vtkErrorMacro(<< status.GetMessage());
  return 0;
}

//------------------------------------------------------------------------------
Status vtkDistributeIsosurface::Distribute(isosurface::Communicator& ranks,
  vtkStabbingContour* contour, vtkInformation* outInfo, vtkPolyData* output)
{
  const auto begin = std::chrono::steady_clock::now();
  ContourBlocks blocks;
  blocks.Attributes = true;
  blocks.Normals = contour->GetComputeNormals() != 0;
  std::optional<double> time;
  if (outInfo->Has(Pipeline::UPDATE_TIME_STEP()))
  {
    time = outInfo->Get(Pipeline::UPDATE_TIME_STEP());
  }
  ISOSURFACE_RETURN_IF_ERROR(
    isosurface::CollectContourBlocks(contour, ranks.GetRank(), ranks.GetSize(), time, blocks));
  if (blocks.Isovalues.empty())
  {
    return Status::Ok();
  }
  EdgeIndexHeader mine =
    isosurface::DescribeContourBlocks(blocks, this->ArrayError, this->NormalError);
  mine.Settings.Mode = this->Mode == LOSSLESS ? isosurface::EdgeIndexMode::Lossless
    : this->Mode == BOUNDED                   ? isosurface::EdgeIndexMode::Bounded
                                              : isosurface::EdgeIndexMode::Smallest;
  mine.Settings.MaximumError = this->MaximumError;
  mine.Settings.Profile = static_cast<isosurface::EdgeIndexProfile>(this->Profile);
  const Result<EdgeIndexHeader> header = isosurface::ShareHeader(ranks, mine, blocks.HasSamples);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(header.GetStatus()));
  blocks.Arrays = isosurface::ShareArrays(ranks, blocks);

  SurfaceExchange::Settings settings;
  const int ranksOnNode = ranks.GetRanksOnNode();
  settings.Threads =
    this->NumberOfThreads > 0 ? this->NumberOfThreads : isosurface::ChooseThreadCount(ranksOnNode);
  settings.DrawingRanks = this->DrawingRanks;
  settings.RoundBytes = static_cast<std::uint64_t>(this->RoundBytes);
  const isosurface::ContourRequest request =
    MakeRequest(*header, blocks, contour->GetGenerateTriangles() == 0);
  SurfaceExchange exchange(ranks, *header, request, settings);
  const double querySeconds = GetSecondsSince(begin);
  Result<Surface> surface =
    exchange.Run(*blocks.Source, [this](double share) { return this->TellProgress(share); });
  ISOSURFACE_RETURN_IF_ERROR(surface.GetStatus());

  const SurfaceExchange::Cost& cost = exchange.GetCost();
  AddCost(ranks.GetRank(), cost, output);
  AddToFieldData(output, "Triangles", surface->NumberOfTriangles);
  AddToFieldData(output, "RawBytes", isosurface::GetSurfaceBytes(*surface));
  AddToFieldData(output, "QuerySeconds", querySeconds);
  AddToFieldData(output, "Level", blocks.Level);
  vtkLogF(1,
    "Distribute Isosurface: rank %d: %llu points encoded to %llu bytes, %llu bytes sent, %zu "
    "triangles; query %.4f s, encode %.4f s, choose %.4f s, exchange %.4f s, decode %.4f s",
    ranks.GetRank(), static_cast<unsigned long long>(cost.EncodedPoints),
    static_cast<unsigned long long>(cost.EncodedBytes),
    static_cast<unsigned long long>(cost.SentBytes), surface->NumberOfTriangles, querySeconds,
    cost.EncodeSeconds, cost.ChooseSeconds, cost.ExchangeSeconds, cost.DecodeSeconds);
  isosurface::MoveToPolyData(
    *surface, blocks.Arrays, contour->GetComputeScalars() ? header->Array : "", output);
  isosurface::StoreRanges(output, settings.Threads);
  if (header->Time)
  {
    output->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *header->Time);
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
bool vtkDistributeIsosurface::TellProgress(double share)
{
  this->UpdateProgress(share);
  return !this->CheckAbort();
}

//------------------------------------------------------------------------------
void vtkDistributeIsosurface::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Mode: " << this->Mode << "\n";
  os << indent << "MaximumError: " << this->MaximumError << "\n";
  os << indent << "Profile: " << this->Profile << "\n";
  os << indent << "NormalError: " << this->NormalError << "\n";
  os << indent << "ArrayError: " << this->ArrayError << "\n";
  os << indent << "DrawingRanks: " << this->DrawingRanks << "\n";
  os << indent << "RoundBytes: " << this->RoundBytes << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
