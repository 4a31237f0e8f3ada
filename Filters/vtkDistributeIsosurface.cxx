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
#include "CollectContourBlocks.h"
#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "ImageSamples.h"
#include "MatchVTK.h"
#include "Ranks/Redistribution/SurfaceExchange.h"
#include "SurfaceFieldData.h"
#include "SurfacePolyData.h"

#include <chrono>
#include <cstdint>
#include <optional>
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

constexpr const char* NotDistributed = "the isosurface cannot be distributed";

void AddCost(int rank, const SurfaceExchange& exchange, const Surface& surface, double querySeconds,
  vtkPolyData* output)
{
  const SurfaceExchange::Cost& cost = exchange.GetCost();
  const auto add = [output](const char* name, auto value)
  { isosurface::AddToFieldData(output, name, value); };
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
  add("RawBytes", isosurface::GetSurfaceBytes(surface));
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

// The surface that is asked for of the blocks.
isosurface::ContourRequest MakeRequest(
  const EdgeIndexHeader& header, const ContourBlocks& blocks, bool polygons)
{
  isosurface::ContourRequest request;
  request.Isovalues = header.Isovalues;
  request.Normals = blocks.Normals;
  isosurface::MatchVTK(request);
  request.Precision = blocks.Precision;
  request.GlobalIds = true;
  request.Offsets = true;
  request.Polygons = polygons;
  request.Attributes = isosurface::GetLayouts(blocks.Arrays);
  return request;
}

} // namespace

struct vtkDistributeIsosurface::Steps
{
  vtkDistributeIsosurface& Filter;
  isosurface::Communicator& Ranks;
  vtkStabbingContour* Contour;

  /// This rank's piece of the surface. Collective.
  Status Distribute(vtkInformation* outInfo, vtkPolyData* output, ContourBlocks& blocks) const;
  /// What the blocks of all ranks are encoded with. Collective.
  Result<EdgeIndexHeader> MakeHeader(const ContourBlocks& blocks, int threads) const;
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
  isosurface::ControllerCommunicator ranks(this->Controller);
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
    isosurface::IgnoreAbortedInput(*this);
    const Steps steps = { *this, ranks, contour };
    status = isosurface::RunCollective(NotDistributed,
      [&]
      {
        return isosurface::RunWithContourBlocks(this, ranks,
          [&](ContourBlocks& blocks)
          { return steps.Distribute(output->GetInformationObject(0), polyData, blocks); });
      });
  }
  if (status.IsOk())
  {
    return 1;
  }
  polyData->Initialize();
  return isosurface::EndExecution(this, output, status);
}

Result<EdgeIndexHeader> vtkDistributeIsosurface::Steps::MakeHeader(
  const ContourBlocks& blocks, int threads) const
{
  isosurface::BlockCoding coding;
  coding.Settings.Mode = this->Filter.Mode == LOSSLESS ? isosurface::EdgeIndexMode::Lossless
    : this->Filter.Mode == BOUNDED                     ? isosurface::EdgeIndexMode::Bounded
                                                       : isosurface::EdgeIndexMode::Smallest;
  coding.Settings.MaximumError = this->Filter.MaximumError;
  coding.Settings.Profile = static_cast<isosurface::EdgeIndexProfile>(this->Filter.Profile);
  coding.ArrayError = this->Filter.ArrayError;
  coding.NormalError = this->Filter.NormalError;
  isosurface::ContourRequest request;
  isosurface::MatchVTK(request);
  return isosurface::MakeSurfaceHeader(this->Ranks, blocks, coding, request, threads, {});
}

Status vtkDistributeIsosurface::Steps::Distribute(
  vtkInformation* outInfo, vtkPolyData* output, ContourBlocks& blocks) const
{
  const auto begin = std::chrono::steady_clock::now();
  isosurface::Communicator& ranks = this->Ranks;
  blocks.Attributes = true;
  blocks.Normals = this->Contour->GetComputeNormals() != 0;
  std::optional<double> time;
  if (outInfo->Has(Pipeline::UPDATE_TIME_STEP()))
  {
    time = outInfo->Get(Pipeline::UPDATE_TIME_STEP());
  }
  ISOSURFACE_RETURN_IF_ERROR(isosurface::CollectContourBlocks(
    this->Contour, ranks.GetRank(), ranks.GetSize(), time, blocks));
  if (blocks.Isovalues.empty())
  {
    return Status::Ok();
  }
  SurfaceExchange::Settings settings;
  settings.Threads = ranks.ChooseThreads(this->Filter.NumberOfThreads);
  settings.DrawingRanks = this->Filter.DrawingRanks;
  settings.RoundBytes = static_cast<std::uint64_t>(this->Filter.RoundBytes);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const EdgeIndexHeader header, this->MakeHeader(blocks, settings.Threads));
  ISOSURFACE_ASSIGN_OR_RETURN(blocks.Arrays, isosurface::ShareArrays(ranks, blocks));

  const isosurface::ContourRequest request =
    MakeRequest(header, blocks, this->Contour->GetGenerateTriangles() == 0);
  SurfaceExchange exchange(ranks, header, request, settings);
  const double querySeconds =
    std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ISOSURFACE_ASSIGN_OR_RETURN(
    Surface surface, exchange.Run(*blocks.Source, isosurface::MakeProgress(this->Filter)));

  const auto fill = [&]
  {
    AddCost(ranks.GetRank(), exchange, surface, querySeconds, output);
    isosurface::AddToFieldData(output, "Level", blocks.Level);
    isosurface::StoreLengthUnit(output, header.Geometry.Unit);
    isosurface::MoveToPolyData(
      surface, blocks.Arrays, this->Contour->GetComputeScalars() ? header.Array : "", output);
    isosurface::StoreRanges(output, settings.Threads);
    if (header.Time)
    {
      output->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *header.Time);
    }
    return Status::Ok();
  };
  return isosurface::AttemptOnAll(ranks, NotDistributed, fill);
}

void vtkDistributeIsosurface::SetProfile(int profile)
{
  const int nearest = isosurface::ChooseProfile(this, profile);
  if (this->Profile != nearest)
  {
    this->Profile = nearest;
    this->Modified();
  }
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
