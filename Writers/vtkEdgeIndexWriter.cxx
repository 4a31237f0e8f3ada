// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkEdgeIndexWriter.h"

#include "vtkStabbingContour.h"

#include "vtkAlgorithmOutput.h"
#include "vtkCommand.h"
#include "vtkErrorCode.h"
#include "vtkInformation.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ContourExecution.h"
#include "ErrorReport.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/OutputCheck.h"
#include "Ground/Base/PrintableText.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>

vtkStandardNewMacro(vtkEdgeIndexWriter);
vtkCxxSetObjectMacro(vtkEdgeIndexWriter, Controller, vtkMultiProcessController);

namespace
{
using isosurface::Status;
using isosurface::StatusCode;
using Pipeline = vtkStreamingDemandDrivenPipeline;

Status CheckContour(vtkStabbingContour* contour)
{
  const auto refuse = [](const char* reason)
  { return Status(StatusCode::InvalidArgument, reason); };
  if (!contour)
  {
    return refuse("Only the unchanged output of Isosurface can be written to an edge-index "
                  "file, which holds where the surface crosses the grid of its volume: save that "
                  "output, before it is clipped or filtered (its UseRegion limits it to a box), or "
                  "save this surface in another format, such as .vtp.");
  }
  if (contour->GetDropDegenerateTriangles() && !contour->GetCloseBoundary())
  {
    return refuse("An edge-index file holds all triangles of an open surface: turn "
                  "DropDegenerateTriangles of Isosurface off.");
  }
  if (contour->GetSkipNotANumber())
  {
    return refuse("An edge-index file cannot hold the holes that SkipNotANumber leaves: turn "
                  "SkipNotANumber of Isosurface off.");
  }
  if (contour->GetComputeIslandIds())
  {
    return refuse("An edge-index file has no arrays of triangles: turn ComputeIslandIds of "
                  "Isosurface off; or save this surface in another format, such as .vtp.");
  }
  if (!contour->GetGenerateTriangles())
  {
    return refuse("An edge-index file holds triangles, not polygons: turn GenerateTriangles of "
                  "Isosurface on.");
  }
  return Status::Ok();
}

// The name of the n-th file of a series.
std::string MakeFileName(const std::string& path, std::size_t step)
{
  const std::size_t slash = path.rfind('/');
  const std::size_t dot = path.rfind('.');
  const bool hasExtension =
    dot != std::string::npos && (slash == std::string::npos || dot > slash + 1);
  const std::size_t end = hasExtension ? dot : path.size();
  return path.substr(0, end) + "_" + std::to_string(step) + path.substr(end);
}

} // namespace

struct vtkEdgeIndexWriter::Steps
{
  vtkEdgeIndexWriter& Writer;
  isosurface::ControllerCommunicator Ranks;
  vtkStabbingContour* Contour = nullptr;
  double FirstShare = 0; ///< of the progress, of the time step that is being written
  double LastShare = 1;

  explicit Steps(vtkEdgeIndexWriter& writer)
    : Writer(writer)
    , Ranks(writer.Controller)
  {
  }

  /// Writes one file, or one for each time step. Collective.
  Status WriteSurface();
  /// Finds the contour, and the time steps to write; this rank alone.
  Status FindContour(std::vector<double>& times);
  std::vector<double> FindTimeSteps() const;
  Status WriteStep(const std::optional<double>& time, const std::string& path);
  isosurface::BlockCoding MakeCoding() const;
  isosurface::EdgeIndexWriteJob::Settings MakeSettings();
};

vtkEdgeIndexWriter::vtkEdgeIndexWriter()
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkEdgeIndexWriter::~vtkEdgeIndexWriter()
{
  this->SetFileName(nullptr);
  this->SetController(nullptr);
}

int vtkEdgeIndexWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  return 1;
}

int vtkEdgeIndexWriter::Write()
{
  this->SetErrorCode(vtkErrorCode::NoError);
  this->SetAbortExecute(0);
  isosurface::IgnoreAbortedInput(*this);
  this->InvokeEvent(vtkCommand::StartEvent);
  this->WriteData();
  this->InvokeEvent(vtkCommand::EndEvent);
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

void vtkEdgeIndexWriter::WriteData()
{
  Steps steps(*this);
  const Status status = steps.WriteSurface();
  if (!status.IsOk())
  {
    this->SetErrorCode(FindErrorCode(status));
    if (status.GetCode() != StatusCode::Aborted)
    {
      vtkErrorMacro(<< isosurface::MakePrintable(status.GetMessage()));
    }
  }
}

std::vector<double> vtkEdgeIndexWriter::Steps::FindTimeSteps() const
{
  this->Contour->UpdateInformation();
  vtkInformation* info = this->Contour->GetOutputInformation(0);
  if (!this->Writer.WriteAllTimeSteps || !info->Has(Pipeline::TIME_STEPS()))
  {
    return {};
  }
  const double* times = info->Get(Pipeline::TIME_STEPS());
  return std::vector<double>(times, times + info->Length(Pipeline::TIME_STEPS()));
}

Status vtkEdgeIndexWriter::Steps::FindContour(std::vector<double>& times)
{
  const char* path = this->Writer.FileName;
  if (!path || !*path)
  {
    return Status(StatusCode::InvalidArgument, "No file name is set.");
  }
  if (this->Writer.GetNumberOfInputConnections(0) > 0)
  {
    this->Contour = vtkStabbingContour::FindBehind(this->Writer.GetInputConnection(0, 0));
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckContour(this->Contour));
  times = this->FindTimeSteps();
  return Status::Ok();
}

Status vtkEdgeIndexWriter::Steps::WriteSurface()
{
  std::vector<double> times;
  const Status found = this->FindContour(times);
  const char* path = this->Writer.FileName;
  const std::string name = path ? path : "";
  // So many files are written, each by all ranks.
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(found,
    { { isosurface::ComputeChecksum(times.data(), times.size() * sizeof(times[0])),
        "the time steps to write are not the same on all ranks" },
      { isosurface::ComputeChecksum(name.data(), name.size()),
        name + ": the file name is not the same on all ranks" } }));
  if (times.empty())
  {
    vtkInformation* inInfo = this->Writer.GetInputInformation();
    std::optional<double> time;
    if (inInfo->Has(Pipeline::UPDATE_TIME_STEP()))
    {
      time = inInfo->Get(Pipeline::UPDATE_TIME_STEP());
    }
    return this->WriteStep(time, path);
  }
  for (std::size_t step = 0; step < times.size(); ++step)
  {
    this->FirstShare = static_cast<double>(step) / static_cast<double>(times.size());
    this->LastShare = static_cast<double>(step + 1) / static_cast<double>(times.size());
    ISOSURFACE_RETURN_IF_ERROR(this->WriteStep(times[step], MakeFileName(path, step)));
  }
  return Status::Ok();
}

isosurface::BlockCoding vtkEdgeIndexWriter::Steps::MakeCoding() const
{
  const vtkEdgeIndexWriter& writer = this->Writer;
  isosurface::BlockCoding coding;
  coding.Settings.Mode = static_cast<isosurface::EdgeIndexMode>(writer.Mode);
  coding.Settings.Profile = static_cast<isosurface::EdgeIndexProfile>(writer.Profile);
  coding.Settings.MaximumError = writer.MaximumError;
  coding.Settings.QuantizationBits = writer.QuantizationBits;
  coding.PreviewLevel = writer.PreviewLevel;
  coding.ArrayError = writer.ArrayError;
  coding.NormalError = writer.NormalError;
  return coding;
}

isosurface::EdgeIndexWriteJob::Settings vtkEdgeIndexWriter::Steps::MakeSettings()
{
  isosurface::EdgeIndexWriteJob::Settings settings;
  settings.Threads = this->Ranks.ChooseThreads(this->Writer.NumberOfThreads);
  settings.MemoryBytes = static_cast<std::uint64_t>(this->Writer.MemoryLimit) << 20;
  settings.Warn = [this](const std::string& warning)
  { vtkWarningWithObjectMacro(&this->Writer, << warning); };
  return settings;
}

Status vtkEdgeIndexWriter::Steps::WriteStep(
  const std::optional<double>& time, const std::string& path)
{
  const isosurface::BlockArrays wanted = {
    this->Writer.WriteNormals && this->Contour->GetComputeNormals(), this->Writer.WriteArrays != 0
  };
  const bool hasArrays =
    wanted.Normals || (wanted.Attributes && this->Contour->GetNumberOfInterpolatedArrays() > 0);
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(!hasArrays || !this->Contour->GetCloseBoundary()
      ? Status::Ok()
      : Status(StatusCode::InvalidArgument,
          "An edge-index file has no arrays on the caps that CloseBoundary adds: turn WriteArrays "
          "and WriteNormals off.")));
  const auto write = [&](isosurface::ContourBlocks& blocks) -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(
      blocks.Volume ? isosurface::CheckIsOther(path, blocks.Volume->GetPath()) : Status::Ok()));
    const auto written =
      isosurface::WriteBlocks(this->Ranks, blocks, this->MakeCoding(), path, this->MakeSettings(),
        isosurface::MakeProgress(this->Writer, this->FirstShare, this->LastShare));
    if (written.IsOk() && this->Ranks.GetRank() == 0)
    {
      vtkLogF(1, "%s: %llu blocks, %llu points, %llu bytes", path.c_str(),
        static_cast<unsigned long long>(written->Records),
        static_cast<unsigned long long>(written->Points),
        static_cast<unsigned long long>(written->Bytes));
    }
    return written.GetStatus();
  };
  return isosurface::RunCollective(path,
    [&]
    {
      return isosurface::ContourExecution::TakeBlocks(
        &this->Writer, *this->Contour, this->Ranks, time, wanted, write);
    });
}

void vtkEdgeIndexWriter::SetProfile(int profile)
{
  isosurface::SetProfile(this, profile, this->Profile);
}

void vtkEdgeIndexWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "Mode: " << this->Mode << "\n";
  os << indent << "MaximumError: " << this->MaximumError << "\n";
  os << indent << "QuantizationBits: " << this->QuantizationBits << "\n";
  os << indent << "Profile: " << this->Profile << "\n";
  os << indent << "WriteArrays: " << this->WriteArrays << "\n";
  os << indent << "ArrayError: " << this->ArrayError << "\n";
  os << indent << "WriteNormals: " << this->WriteNormals << "\n";
  os << indent << "NormalError: " << this->NormalError << "\n";
  os << indent << "PreviewLevel: " << this->PreviewLevel << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "WriteAllTimeSteps: " << this->WriteAllTimeSteps << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
