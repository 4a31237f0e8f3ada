// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeWriter.h"

#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArraySelection.h"
#include "vtkErrorCode.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ArrayChoice.h"
#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/PrintableText.h"
#include "ImageSamples.h"
#include "LocalVolume.h"
#include "PipelineSource.h"
#include "Storage/Sampling/StoredBoxSource.h"
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "WriterInput.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

vtkStandardNewMacro(vtkBlockedVolumeWriter);
vtkCxxSetObjectMacro(vtkBlockedVolumeWriter, Controller, vtkMultiProcessController);

namespace
{
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;
using Pipeline = vtkStreamingDemandDrivenPipeline;
} // namespace

/**
 * Writes the time steps by Core's writer, which holds those that are not published yet.
 */
struct vtkBlockedVolumeWriter::Session
{
  explicit Session(vtkBlockedVolumeWriter& owner)
    : Owner(owner)
    , Ranks(owner.Controller)
    , Writer(Ranks)
  {
  }

  /// Of the blocked volume whose samples arrive at the input unchanged; null if there is none.
  vtkBlockedVolumeHandle* FindHandle() const;
  Status CollectInput(isosurface::LocalVolume& local);
  /// The grid at full resolution, and those chosen arrays of which the input has a level.
  void DescribeVolume(const vtkBlockedVolumeHandle& handle, const isosurface::ArrayChoice& choice,
    isosurface::LocalVolume& local) const;
  Status CollectImage(const isosurface::WriterInput& input, const isosurface::ArrayChoice& choice,
    isosurface::LocalVolume& local) const;
  /// The lines of a rectilinear grid: those of a piece, or of the whole extent behind a slice.
  Status CollectLines(
    const isosurface::WriterInput& input, const int whole[6], isosurface::LocalVolume& local) const;
  void SetTime(const std::optional<double>& time, isosurface::LocalVolume& local) const;
  Result<std::unique_ptr<isosurface::BoxSource>> OpenSource(const isosurface::LocalVolume& local);
  isosurface::BlockedVolumeSettings MakeSettings(const isosurface::LocalVolume& local) const;
  /// Collective.
  Status WriteStep(const isosurface::LocalVolume& local);

  vtkBlockedVolumeWriter& Owner;
  isosurface::ControllerCommunicator Ranks;
  isosurface::BlockedVolumeWriter Writer;
};

vtkBlockedVolumeWriter::vtkBlockedVolumeWriter()
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkBlockedVolumeWriter::~vtkBlockedVolumeWriter()
{
  this->Writing.reset();
  this->SetFileName(nullptr);
  this->SetController(nullptr);
}

vtkImageData* vtkBlockedVolumeWriter::GetInput()
{
  return vtkImageData::SafeDownCast(this->Superclass::GetInput());
}

vtkImageData* vtkBlockedVolumeWriter::GetInput(int port)
{
  return vtkImageData::SafeDownCast(this->Superclass::GetInput(port));
}

int vtkBlockedVolumeWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkRectilinearGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

vtkDataArraySelection* vtkBlockedVolumeWriter::GetPointDataArraySelection()
{
  return this->PointDataArraySelection;
}

vtkMTimeType vtkBlockedVolumeWriter::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->PointDataArraySelection->GetMTime());
}

bool vtkBlockedVolumeWriter::IsLastTimeStep() const
{
  return this->TimeIndex + 1 >= this->TimeSteps.size();
}

vtkTypeBool vtkBlockedVolumeWriter::ProcessRequest(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_INFORMATION()))
  {
    this->Writing.reset();
    this->TimeIndex = 0;
    this->TimeSteps.clear();
    if (this->WriteAllTimeSteps && inInfo->Has(Pipeline::TIME_STEPS()))
    {
      const double* times = inInfo->Get(Pipeline::TIME_STEPS());
      this->TimeSteps.assign(times, times + inInfo->Length(Pipeline::TIME_STEPS()));
    }
  }
  if (request->Has(Pipeline::REQUEST_UPDATE_EXTENT()))
  {
    if (!this->TimeSteps.empty())
    {
      inInfo->Set(Pipeline::UPDATE_TIME_STEP(), this->TimeSteps[this->TimeIndex]);
    }
    if (this->MemoryLimit > 0 && !vtkBlockedVolumeReader::BLOCKED_VOLUME()->GetHandle(inInfo))
    {
      // Enough to learn of the arrays; WriteData() asks for the rest.
      isosurface::PipelineSource::AskForFirstSlice(inInfo, this->WriteCellArrays);
      return 1;
    }
    if (this->Controller)
    {
      inInfo->Set(Pipeline::UPDATE_PIECE_NUMBER(), this->Controller->GetLocalProcessId());
      inInfo->Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), this->Controller->GetNumberOfProcesses());
      // Averages at the border of a piece need one cell beyond it.
      inInfo->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), this->WriteCellArrays ? 1 : 0);
      return 1;
    }
  }
  const vtkTypeBool result = this->Superclass::ProcessRequest(request, input, output);
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA()))
  {
    if (this->Writing && !this->IsLastTimeStep())
    {
      ++this->TimeIndex;
      request->Set(Pipeline::CONTINUE_EXECUTING(), 1);
    }
    else
    {
      this->Writing.reset();
      this->TimeIndex = 0;
      request->Remove(Pipeline::CONTINUE_EXECUTING());
    }
  }
  return result;
}

vtkBlockedVolumeHandle* vtkBlockedVolumeWriter::Session::FindHandle() const
{
  return vtkBlockedVolumeReader::BLOCKED_VOLUME()->GetHandle(this->Owner.GetInputInformation());
}

Status vtkBlockedVolumeWriter::Session::CollectInput(isosurface::LocalVolume& local)
{
  if (!this->Owner.FileName || !*this->Owner.FileName)
  {
    return Status(StatusCode::InvalidArgument, "No file name is set.");
  }
  vtkBlockedVolumeHandle* handle = this->FindHandle();
  if (handle)
  {
    ISOSURFACE_RETURN_IF_ERROR(handle->GetStatus());
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto input, isosurface::WriterInput::Find(this->Owner.Superclass::GetInput()));
  vtkImageData* image = input.Image;
  if (!image || image->GetNumberOfPoints() == 0)
  {
    return Status::Ok();
  }
  const bool withCells = this->Owner.WriteCellArrays && !handle;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto choice,
    isosurface::ArrayChoice::Make(image,
      this->Owner.ChooseArraysToWrite ? this->Owner.PointDataArraySelection.Get() : nullptr,
      withCells));
  const bool isFirst = this->Owner.TimeIndex == 0 &&
    (!this->Owner.Controller || this->Owner.Controller->GetLocalProcessId() == 0);
  if (isFirst && !choice.LeftOut.empty())
  {
    vtkWarningWithObjectMacro(&this->Owner, << choice.LeftOut);
  }
  local.WithCells = withCells;
  if (handle)
  {
    this->DescribeVolume(*handle, choice, local);
    return Status::Ok();
  }
  return this->CollectImage(input, choice, local);
}

void vtkBlockedVolumeWriter::Session::DescribeVolume(const vtkBlockedVolumeHandle& handle,
  const isosurface::ArrayChoice& choice, isosurface::LocalVolume& local) const
{
  const isosurface::BlockedVolumeHeader& header = handle.GetVolume()->GetHeader();
  local.Grid = header.Grid;
  if (header.Lines)
  {
    local.Lines = { header.Grid, *header.Lines };
  }
  local.Piece.Box = { { 0, 0, 0 }, header.Grid.GetDimensions() };
  for (const isosurface::ArrayDescription& array : header.Arrays)
  {
    if (choice.Has(array.Name))
    {
      local.Arrays.push_back(array);
    }
  }
  this->SetTime(
    header.TimeSteps[handle.FindTimeStep(this->Owner.GetInputInformation())].Time, local);
}

Status vtkBlockedVolumeWriter::Session::CollectImage(const isosurface::WriterInput& input,
  const isosurface::ArrayChoice& choice, isosurface::LocalVolume& local) const
{
  vtkImageData* image = input.Image;
  vtkInformation* inInfo = this->Owner.GetInputInformation();
  int whole[6];
  image->GetExtent(whole);
  if (!vtkCompositeDataSet::SafeDownCast(this->Owner.Superclass::GetInput()))
  {
    if (inInfo->Has(Pipeline::WHOLE_EXTENT()))
    {
      inInfo->Get(Pipeline::WHOLE_EXTENT(), whole);
    }
  }
  else if (this->Owner.MemoryLimit > 0)
  {
    return Status(StatusCode::Unsupported,
      "the input is composite, so parts of it cannot be asked for; a memory limit needs image "
      "data or a blocked volume");
  }
  else
  {
    isosurface::FindWholeExtent(image, whole);
  }
  local.Grid = isosurface::MakeGridGeometry(image, whole);
  local.Piece.Box = local.WithCells ? isosurface::FindOwnVertices(local.Grid, image)
                                    : isosurface::MakeVertexBox(local.Grid, image->GetExtent());
  if (!isosurface::FindBlanking(local.Grid, image).IsEmpty())
  {
    return Status(StatusCode::InvalidArgument,
      "the input hides cells or points (vtkGhostType), which a blocked volume cannot tell; write "
      "NaN "
      "where there is nothing, and contour with SkipNotANumber");
  }
  this->SetTime(isosurface::FindTime(this->Owner.Superclass::GetInput()), local);
  ISOSURFACE_RETURN_IF_ERROR(
    local.CollectArrays(image, [&](const std::string& name) { return choice.Has(name); }));
  return this->CollectLines(input, whole, local);
}

Status vtkBlockedVolumeWriter::Session::CollectLines(
  const isosurface::WriterInput& input, const int whole[6], isosurface::LocalVolume& local) const
{
  if (!input.Lines)
  {
    return Status::Ok();
  }
  local.Lines = { isosurface::MakeGridGeometry(input.Image, input.Image->GetExtent()),
    *input.Lines };
  if (this->Owner.MemoryLimit > 0)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto lines,
      input.FindWholeLines(
        this->Owner.GetInputConnection(0, 0), this->Owner.GetInputInformation(), whole));
    local.Lines = { local.Grid, std::move(lines) };
    return local.Lines->Lines.Check(local.Grid.GetDimensions());
  }
  return Status::Ok();
}

void vtkBlockedVolumeWriter::Session::SetTime(
  const std::optional<double>& time, isosurface::LocalVolume& local) const
{
  vtkInformation* inInfo = this->Owner.GetInputInformation();
  if (!this->Owner.TimeSteps.empty())
  {
    local.Time = { 1, this->Owner.TimeSteps[this->Owner.TimeIndex] };
  }
  else if (time)
  {
    local.Time = { 1, *time };
  }
  else if (this->Owner.AppendTimeStep && inInfo->Has(Pipeline::UPDATE_TIME_STEP()))
  {
    local.Time = { 1, inInfo->Get(Pipeline::UPDATE_TIME_STEP()) };
  }
}

isosurface::BlockedVolumeSettings vtkBlockedVolumeWriter::Session::MakeSettings(
  const isosurface::LocalVolume& local) const
{
  isosurface::BlockedVolumeSettings settings;
  settings.BlockSize = this->Owner.BlockSize;
  settings.NumberOfStores = static_cast<std::uint32_t>(this->Owner.NumberOfStores);
  settings.NumberOfReplicas = static_cast<std::uint32_t>(this->Owner.NumberOfReplicas);
  settings.Distribution = static_cast<isosurface::DistributionMethod>(this->Owner.Distribution);
  settings.RandomSeed = static_cast<std::uint64_t>(this->Owner.RandomSeed);
  settings.Compression.Codec = static_cast<isosurface::SegmentCodec>(this->Owner.Compression);
  settings.Compression.Level = this->Owner.CompressionLevel;
  if (local.Lines)
  {
    settings.Lines = local.Lines->Lines;
  }
  if (local.Time[0] != 0)
  {
    settings.Time = local.Time[1];
  }
  settings.Warn = [this](const std::string& warning)
  { vtkWarningWithObjectMacro(&this->Owner, << warning); };
  settings.Append = this->Owner.AppendTimeStep || this->Owner.TimeIndex > 0;
  settings.Publish = this->Owner.IsLastTimeStep();
  if (this->Owner.MemoryLimit > 0)
  {
    settings.MemoryLimit = static_cast<std::uint64_t>(this->Owner.MemoryLimit) << 20;
  }
  return settings;
}

Result<std::unique_ptr<isosurface::BoxSource>> vtkBlockedVolumeWriter::Session::OpenSource(
  const isosurface::LocalVolume& local)
{
  vtkInformation* inInfo = this->Owner.GetInputInformation();
  if (const vtkBlockedVolumeHandle* handle = this->FindHandle())
  {
    std::vector<std::size_t> arrays;
    for (const isosurface::ArrayDescription& array : local.Arrays)
    {
      arrays.push_back(*handle->GetVolume()->GetHeader().FindArray(array.Name));
    }
    ISOSURFACE_ASSIGN_OR_RETURN(auto source,
      isosurface::StoredBoxSource::Make(
        handle->GetVolume(), handle->FindTimeStep(inInfo), arrays, this->Ranks.ChooseThreads(0)));
    return std::unique_ptr<isosurface::BoxSource>(std::move(source));
  }
  if (this->Owner.MemoryLimit > 0)
  {
    return std::unique_ptr<isosurface::BoxSource>(std::make_unique<isosurface::PipelineSource>(
      this->Owner.GetInputConnection(0, 0), inInfo, local.Grid, local.Arrays, local.WithCells));
  }
  return std::unique_ptr<isosurface::BoxSource>(
    std::make_unique<isosurface::MemorySource>(local.Piece));
}

Status vtkBlockedVolumeWriter::Session::WriteStep(const isosurface::LocalVolume& local)
{
  const auto opened = this->OpenSource(local);
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(opened.GetStatus()));
  const double steps = static_cast<double>(std::max<std::size_t>(1, this->Owner.TimeSteps.size()));
  const auto step = static_cast<double>(this->Owner.TimeIndex);
  const auto written = this->Writer.Write(this->Owner.FileName, local.Grid, local.Arrays, **opened,
    this->MakeSettings(local),
    isosurface::MakeProgress(this->Owner, step / steps, (step + 1) / steps));
  if (written.IsOk() && this->Ranks.GetRank() == 0)
  {
    vtkLogF(1, "%s: %llu blocks of %d cells a side in %zu stores, %llu bytes", this->Owner.FileName,
      static_cast<unsigned long long>(written->Blocks), this->Owner.BlockSize,
      written->Stores.size(), static_cast<unsigned long long>(written->Bytes));
  }
  return written.GetStatus();
}

void vtkBlockedVolumeWriter::WriteData()
{
  if (!this->Writing)
  {
    this->Writing = std::make_unique<Session>(*this);
  }
  isosurface::ControllerCommunicator& ranks = this->Writing->Ranks;
  isosurface::LocalVolume local;
  // So often all ranks come here; and they ask for a slice, or for all of their pieces.
  const std::vector<double>& times = this->TimeSteps;
  const vtkBlockedVolumeHandle* handle = this->Writing->FindHandle();
  Status status = ranks.Agree(this->Writing->CollectInput(local),
    { { isosurface::ComputeChecksum(times.data(), times.size() * sizeof(double)),
        "the time steps to write are not the same on all ranks" },
      { this->MemoryLimit > 0 ? 1U : 0U, "some ranks have a memory limit, some have none" },
      { handle ? 1U : 0U,
        "some ranks have a blocked volume at the input of the writer, and some have images" },
      handle ? handle->MakeCommonValue() : isosurface::CommonValue{ 0, "" },
      // Ranks without a part of the input read and write blocks, too.
      { handle ? handle->FindTimeStep(this->GetInputInformation()) : 0U,
        "the ranks ask for different time steps" } });
  if (status.IsOk())
  {
    status = local.Agree(ranks);
  }
  if (status.IsOk())
  {
    if (this->MemoryLimit > 0)
    {
      // The slice that is here is one of many that are asked for.
      local.Owners.clear();
    }
    status = this->Writing->WriteStep(local);
  }
  if (!status.IsOk())
  {
    // Steps that were not published go with it.
    this->Writing.reset();
    this->SetErrorCode(FindErrorCode(status));
    if (status.GetCode() != StatusCode::Aborted)
    {
      vtkErrorMacro(<< isosurface::MakePrintable(status.GetMessage()));
    }
  }
}

void vtkBlockedVolumeWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "BlockSize: " << this->BlockSize << "\n";
  os << indent << "NumberOfStores: " << this->NumberOfStores << "\n";
  os << indent << "NumberOfReplicas: " << this->NumberOfReplicas << "\n";
  os << indent << "Distribution: " << this->Distribution << "\n";
  os << indent << "RandomSeed: " << this->RandomSeed << "\n";
  os << indent << "Compression: " << this->Compression << "\n";
  os << indent << "CompressionLevel: " << this->CompressionLevel << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "ChooseArraysToWrite: " << this->ChooseArraysToWrite << "\n";
  os << indent << "WriteCellArrays: " << this->WriteCellArrays << "\n";
  os << indent << "PointDataArraySelection:\n";
  this->PointDataArraySelection->PrintSelf(os, indent.GetNextIndent());
  os << indent << "AppendTimeStep: " << this->AppendTimeStep << "\n";
  os << indent << "WriteAllTimeSteps: " << this->WriteAllTimeSteps << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
