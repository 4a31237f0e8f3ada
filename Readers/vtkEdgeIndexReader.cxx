// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkEdgeIndexReader.h"

#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ArrayRanges.h"
#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Formats/Files/SurfaceFile.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/WithinMemory.h"
#include "ImageSamples.h"
#include "MatchVTK.h"
#include "SurfacePolyData.h"

#include <algorithm>

vtkStandardNewMacro(vtkEdgeIndexReader);
vtkCxxSetObjectMacro(vtkEdgeIndexReader, Controller, vtkMultiProcessController);

using namespace isosurface;
using Pipeline = vtkStreamingDemandDrivenPipeline;

struct vtkEdgeIndexReader::Internals
{
  vtkEdgeIndexReader& Reader;
  std::shared_ptr<SurfaceFile> File; ///< null if it could not be opened
  vtkMTimeType OpenTime = 0;         ///< the reader's MTime when File was opened
  std::string OpenError;             ///< what kept it from being opened
  vtkNew<vtkDoubleArray> ContourValues;

  explicit Internals(vtkEdgeIndexReader& reader)
    : Reader(reader)
  {
  }

  /// Opens the file anew if the properties changed.
  Status OpenFile();
  /// What tells ranks that see different files under one path, or have different properties.
  std::vector<CommonValue> MakeCommonValues() const;
  EdgeIndexSelection MakeSelection(vtkInformation* outInfo) const;
  Status ReadSurface(vtkInformation* outInfo, int threads, vtkPolyData* output);
};

vtkEdgeIndexReader::vtkEdgeIndexReader()
  : Internal(new Internals(*this))
{
  this->SetNumberOfInputPorts(0);
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkEdgeIndexReader::~vtkEdgeIndexReader()
{
  this->SetFileName(nullptr);
  this->SetController(nullptr);
}

int vtkEdgeIndexReader::CanReadFile(const char* fileName)
{
  return SurfaceFile::CanRead(fileName ? fileName : "");
}

vtkDoubleArray* vtkEdgeIndexReader::GetContourValues()
{
  return this->Internal->ContourValues;
}

Status vtkEdgeIndexReader::Internals::OpenFile()
{
  if (this->OpenTime != this->Reader.GetMTime())
  {
    this->OpenTime = this->Reader.GetMTime();
    this->File.reset();
    this->OpenError = "No file name is set.";
    if (const char* name = this->Reader.FileName; name && *name)
    {
      auto file = RunWithinMemory(
        name, ": there is not enough memory to open it", [&] { return SurfaceFile::Open(name); });
      this->OpenError = file.GetStatus().GetMessage();
      this->File = file.IsOk() ? std::move(*file) : nullptr;
    }
  }
  return this->File ? Status::Ok() : Status(StatusCode::NotFound, this->OpenError);
}

std::vector<CommonValue> vtkEdgeIndexReader::Internals::MakeCommonValues() const
{
  const vtkEdgeIndexReader& reader = this->Reader;
  Fingerprint properties;
  for (const vtkTypeBool is :
    { reader.Preview, reader.UseRegion, reader.ComputeScalars, reader.ComputeNormals })
  {
    properties.AddNumber(is ? 1 : 0);
  }
  properties.AddReals(reader.RegionPosition);
  properties.AddReals(reader.RegionLength);
  return {
    this->File ? MakeCommonFile(this->File->GetPath(), this->File->GetFingerprint())
               : CommonValue{ 0, "" },
    { properties.Get(), "the properties of the reader are not the same on all ranks" },
  };
}

int vtkEdgeIndexReader::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  outInfo->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  outInfo->Remove(Pipeline::TIME_STEPS());
  outInfo->Remove(Pipeline::TIME_RANGE());
  this->Internal->ContourValues->Reset();
  // What fails here fails in RequestData, too, where all ranks agree on it.
  if (!this->Internal->OpenFile().IsOk())
  {
    return 1;
  }
  const EdgeIndexHeader& header = this->Internal->File->GetHeader();
  for (const double isovalue : header.Isovalues)
  {
    this->Internal->ContourValues->InsertNextValue(isovalue);
  }
  if (header.Time)
  {
    const double range[2] = { *header.Time, *header.Time };
    outInfo->Set(Pipeline::TIME_STEPS(), range, 1);
    outInfo->Set(Pipeline::TIME_RANGE(), range, 2);
  }
  return 1;
}

int vtkEdgeIndexReader::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkPolyData* polyData = vtkPolyData::GetData(output, 0);
  ControllerCommunicator ranks(this->Controller);
  const Status opened = this->Internal->OpenFile();
  Status status = ranks.Agree(opened, this->Internal->MakeCommonValues());
  if (status.IsOk())
  {
    const int threads = ranks.ChooseThreads(this->NumberOfThreads);
    if (ranks.GetRank() == 0 && !this->Internal->File->GetMissing().empty())
    {
      vtkWarningMacro(<< this->Internal->File->GetMissing());
    }
    if (ranks.GetRank() == 0 && this->Preview &&
      this->Internal->File->GetHeader().PreviewLevel == 0)
    {
      vtkWarningMacro(<< this->FileName
                      << ": the file has no preview: the surface is read in full.");
    }
    status = RunWithinMemory(this->FileName, ": there is not enough memory for the isosurface.",
      [&]
      { return this->Internal->ReadSurface(output->GetInformationObject(0), threads, polyData); });
    if (status.IsOk() && IsAborted(*this))
    {
      status = Status(StatusCode::Aborted, "reading was aborted");
    }
    status = ranks.Agree(status);
  }
  if (!status.IsOk() && status.GetCode() != StatusCode::Aborted)
  {
    this->Internal->OpenTime = 0; // the file may be whole the next time
  }
  return EndExecution(this, output, status);
}

EdgeIndexSelection vtkEdgeIndexReader::Internals::MakeSelection(vtkInformation* outInfo) const
{
  const EdgeIndexHeader& header = this->File->GetHeader();
  EdgeIndexSelection selection;
  selection.Preview = this->Reader.Preview && header.PreviewLevel > 0;
  if (this->Reader.UseRegion)
  {
    const double* low = this->Reader.RegionPosition;
    const double* size = this->Reader.RegionLength;
    selection.Box = this->File->FindVertices(
      { low[0], low[0] + size[0], low[1], low[1] + size[1], low[2], low[2] + size[2] });
  }
  selection.Piece = outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER());
  selection.NumberOfPieces = std::max(1, outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  return selection;
}

Status vtkEdgeIndexReader::Internals::ReadSurface(
  vtkInformation* outInfo, int threads, vtkPolyData* output)
{
  const EdgeIndexHeader& header = this->File->GetHeader();
  const EdgeIndexSelection selection = this->MakeSelection(outInfo);
  ContourRequest request;
  request.GlobalIds = true;
  request.Offsets = true;
  MatchVTK(request);
  ISOSURFACE_ASSIGN_OR_RETURN(auto surface,
    this->File->Read(
      selection, request, this->Reader.ComputeNormals != 0, threads, MakeProgress(this->Reader)));
  vtkLogF(1, "%s: piece %d of %d: %zu blocks, %zu triangles, %.4f s", this->Reader.FileName,
    selection.Piece, selection.NumberOfPieces, surface.NumberOfBlocks, surface.NumberOfTriangles,
    surface.TotalSeconds);
  MoveToPolyData(surface,
    selection.Preview ? std::vector<InterpolatedArray>() : this->File->GetArrays(),
    this->Reader.ComputeScalars ? header.Array : "", output);
  StoreRanges(output, threads);
  StoreLengthUnit(output, header.Geometry.Unit);
  if (header.Time)
  {
    output->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *header.Time);
  }
  return Status::Ok();
}

void vtkEdgeIndexReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "Preview: " << this->Preview << "\n";
  os << indent << "UseRegion: " << this->UseRegion << "\n";
  os << indent << "RegionPosition: " << this->RegionPosition[0] << " " << this->RegionPosition[1]
     << " " << this->RegionPosition[2] << "\n";
  os << indent << "RegionLength: " << this->RegionLength[0] << " " << this->RegionLength[1] << " "
     << this->RegionLength[2] << "\n";
  os << indent << "ComputeScalars: " << this->ComputeScalars << "\n";
  os << indent << "ComputeNormals: " << this->ComputeNormals << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
