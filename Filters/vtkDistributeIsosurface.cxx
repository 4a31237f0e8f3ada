// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkDistributeIsosurface.h"

#include "vtkBlockConsumerPipeline.h"
#include "vtkStabbingContour.h"

#include "vtkAlgorithmOutput.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ArrayRanges.h"
#include "ContourExecution.h"
#include "ErrorReport.h"
#include "ImageSamples.h"
#include "RangedArray.h"
#include "Ranks/Redistribution/SurfaceExchange.h"
#include "SurfacePolyData.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

vtkStandardNewMacro(vtkDistributeIsosurface);
vtkCxxSetObjectMacro(vtkDistributeIsosurface, Controller, vtkMultiProcessController);

using namespace isosurface;

namespace
{
using Pipeline = vtkStreamingDemandDrivenPipeline;

constexpr const char* NotDistributed = "the isosurface cannot be distributed";

void AddCost(int rank, const SurfaceExchange& exchange, const Surface& surface, double querySeconds,
  vtkPolyData* output)
{
  const SurfaceExchange::Cost& cost = exchange.GetCost();
  const auto add = [output](const char* name, auto value) { AddToFieldData(output, name, value); };
  add("Rank", rank);
  add("ExtractedPoints", cost.EncodedPoints);
  add("ReceivedPoints", cost.ReceivedPoints);
  add("EncodedBytes", cost.EncodedBytes);
  add("SentBytes", cost.SentBytes);
  add("Rounds", cost.Rounds);
  add("EncodeSeconds", cost.EncodeSeconds);
  add("ChooseSeconds", cost.ChooseSeconds);
  add("ExchangeSeconds", cost.ExchangeSeconds);
  add("DecodeSeconds", cost.DecodeSeconds);
  add("Triangles", surface.NumberOfTriangles);
  add("RawBytes", GetSurfaceBytes(surface));
  add("QuerySeconds", querySeconds);
  vtkLogF(1,
    "Distribute Isosurface: rank %d: %llu points encoded to %llu bytes, %llu bytes sent, %zu "
    "triangles; query %.4f s, encode %.4f s, choose %.4f s, exchange %.4f s, decode %.4f s",
    rank, static_cast<unsigned long long>(cost.EncodedPoints),
    static_cast<unsigned long long>(cost.EncodedBytes),
    static_cast<unsigned long long>(cost.SentBytes), surface.NumberOfTriangles, querySeconds,
    cost.EncodeSeconds, cost.ChooseSeconds, cost.ExchangeSeconds, cost.DecodeSeconds);
}

Status CheckContour(vtkStabbingContour* contour)
{
  const std::pair<bool, const char*> refusals[] = {
    { !contour,
      "Only the unchanged output of Isosurface can be distributed, which knows "
      "where the surface crosses the grid of its volume: put Distribute Isosurface right "
      "behind it, and other filters behind Distribute Isosurface." },
    { contour && contour->GetCloseBoundary(),
      "The caps that CloseBoundary adds cannot be distributed: turn CloseBoundary of "
      "Isosurface off." },
    { contour && contour->GetSkipNotANumber(),
      "The holes that SkipNotANumber leaves cannot be distributed: turn SkipNotANumber "
      "of Isosurface off." },
    { contour && contour->GetDropDegenerateTriangles(),
      "A surface is always distributed with all its triangles: turn "
      "DropDegenerateTriangles of Isosurface off, or put Clean behind Distribute "
      "Isosurface." },
    { contour && contour->GetComputeIslandIds(),
      "A surface is distributed without arrays of triangles: turn ComputeIslandIds of "
      "Isosurface off." },
  };
  for (const auto& [isRefused, reason] : refusals)
  {
    if (isRefused)
    {
      return { StatusCode::InvalidArgument, reason };
    }
  }
  return Status::Ok();
}

} // namespace

struct vtkDistributeIsosurface::Steps
{
  vtkDistributeIsosurface& Filter;
  Communicator& Ranks;
  std::chrono::steady_clock::time_point Begin;

  BlockCoding MakeCoding() const;
  /// This rank's piece of the surface. Collective.
  Status Distribute(ContourBlocks& blocks, bool withScalars, vtkPolyData* output) const;
};

vtkDistributeIsosurface::vtkDistributeIsosurface()
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkDistributeIsosurface::~vtkDistributeIsosurface()
{
  this->SetController(nullptr);
}

vtkExecutive* vtkDistributeIsosurface::CreateDefaultExecutive()
{
  return vtkBlockConsumerPipeline::New();
}

bool vtkDistributeIsosurface::TakesBlocks() const
{
  return this->Controller && this->Controller->GetNumberOfProcesses() > 1;
}

int vtkDistributeIsosurface::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkPolyData* polyData = vtkPolyData::GetData(output, 0);
  vtkStabbingContour* contour = vtkStabbingContour::FindBehind(this->GetInputConnection(0, 0));
  ControllerCommunicator ranks(this->Controller);
  // Each rank makes the plan of all messages by these.
  Status status = ranks.Agree(CheckContour(contour),
    { { static_cast<std::uint64_t>(this->DrawingRanks), "DrawingRanks differs between the ranks" },
      { static_cast<std::uint64_t>(this->RoundBytes), "RoundBytes differs between the ranks" } });
  if (status.IsOk() && !this->TakesBlocks())
  {
    polyData->ShallowCopy(vtkPolyData::GetData(input[0], 0));
    return 1;
  }
  if (contour && status.IsOk())
  {
    IgnoreAbortedInput(*this);
    const Steps steps = { *this, ranks, std::chrono::steady_clock::now() };
    vtkInformation* outInfo = output->GetInformationObject(0);
    std::optional<double> time;
    if (outInfo->Has(Pipeline::UPDATE_TIME_STEP()))
    {
      time = outInfo->Get(Pipeline::UPDATE_TIME_STEP());
    }
    const auto distribute = [&](ContourBlocks& blocks)
    { return steps.Distribute(blocks, contour->GetComputeScalars() != 0, polyData); };
    status = RunCollective(NotDistributed,
      [&]
      {
        return ContourExecution::TakeBlocks(
          this, *contour, ranks, time, { contour->GetComputeNormals() != 0, true }, distribute);
      });
  }
  return EndExecution(this, output, status);
}

BlockCoding vtkDistributeIsosurface::Steps::MakeCoding() const
{
  BlockCoding coding;
  coding.Settings.Mode = this->Filter.Mode == LOSSLESS ? EdgeIndexMode::Lossless
    : this->Filter.Mode == BOUNDED                     ? EdgeIndexMode::Bounded
                                                       : EdgeIndexMode::Smallest;
  coding.Settings.MaximumError = this->Filter.MaximumError;
  coding.Settings.Profile = static_cast<EdgeIndexProfile>(this->Filter.Profile);
  coding.ArrayError = this->Filter.ArrayError;
  coding.NormalError = this->Filter.NormalError;
  return coding;
}

Status vtkDistributeIsosurface::Steps::Distribute(
  ContourBlocks& blocks, bool withScalars, vtkPolyData* output) const
{
  Communicator& ranks = this->Ranks;
  if (blocks.Request.Isovalues.empty())
  {
    return Status::Ok();
  }
  SurfaceExchange::Settings settings;
  settings.Threads = ranks.ChooseThreads(this->Filter.NumberOfThreads);
  settings.DrawingRanks = this->Filter.DrawingRanks;
  settings.RoundBytes = static_cast<std::uint64_t>(this->Filter.RoundBytes);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto header, MakeSurfaceHeader(ranks, blocks, this->MakeCoding(), settings.Threads, {}));
  ISOSURFACE_ASSIGN_OR_RETURN(blocks.Arrays, ShareArrays(ranks, blocks));
  blocks.Request.Attributes = GetLayouts(blocks.Arrays);
  SurfaceExchange exchange(ranks, header, blocks.Request, settings);
  const double querySeconds =
    std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
  ISOSURFACE_ASSIGN_OR_RETURN(
    Surface surface, exchange.Run(*blocks.Source, MakeProgress(this->Filter)));

  const auto fill = [&]
  {
    AddCost(ranks.GetRank(), exchange, surface, querySeconds, output);
    AddToFieldData(output, "Level", blocks.Level);
    StoreLengthUnit(output, header.Geometry.Unit);
    MoveToPolyData(surface, blocks.Arrays, withScalars ? header.Array : "", output);
    StoreRanges(output, settings.Threads);
    if (header.Time)
    {
      output->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *header.Time);
    }
    return Status::Ok();
  };
  return AttemptOnAll(ranks, NotDistributed, fill);
}

void vtkDistributeIsosurface::SetProfile(int profile)
{
  isosurface::SetProfile(this, profile, this->Profile);
}

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
