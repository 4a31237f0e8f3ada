// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeWriter.h"

#include "vtkErrorCode.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ControllerCommunicator.h"
#include "ImageSamples.h"
#include "LocalVolume.h"
#include "PipelineSource.h"
#include "Store/BlockedVolumeWriter.h"

#include <memory>

vtkStandardNewMacro(vtkBlockedVolumeWriter);
vtkCxxSetObjectMacro(vtkBlockedVolumeWriter, Controller, vtkMultiProcessController);

namespace
{
using isosurface::Status;
using isosurface::StatusCode;
} // namespace

//------------------------------------------------------------------------------
vtkBlockedVolumeWriter::vtkBlockedVolumeWriter()
  : FileName(nullptr)
  , BlockSize(32)
  , NumberOfStores(0)
  , Distribution(GREEDY)
  , RandomSeed(0)
  , Compression(LZ4)
  , CompressionLevel(0)
  , MemoryLimit(0)
  , Controller(nullptr)
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

//------------------------------------------------------------------------------
vtkBlockedVolumeWriter::~vtkBlockedVolumeWriter()
{
  this->SetFileName(nullptr);
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
vtkImageData* vtkBlockedVolumeWriter::GetInput()
{
  return vtkImageData::SafeDownCast(this->Superclass::GetInput());
}

//------------------------------------------------------------------------------
vtkImageData* vtkBlockedVolumeWriter::GetInput(int port)
{
  return vtkImageData::SafeDownCast(this->Superclass::GetInput(port));
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  return 1;
}

//------------------------------------------------------------------------------
vtkTypeBool vtkBlockedVolumeWriter::ProcessRequest(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  if (request->Has(vtkStreamingDemandDrivenPipeline::REQUEST_UPDATE_EXTENT()) &&
    (this->Controller || this->MemoryLimit > 0))
  {
    vtkInformation* inInfo = input[0]->GetInformationObject(0);
    if (this->MemoryLimit > 0)
    {
      // Enough to learn of the arrays; WriteData() asks for the rest.
      isosurface::PipelineSource::AskForFirstSlice(inInfo);
      return 1;
    }
    inInfo->Set(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER(),
      this->Controller->GetLocalProcessId());
    inInfo->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES(),
      this->Controller->GetNumberOfProcesses());
    inInfo->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
    return 1;
  }
  return this->Superclass::ProcessRequest(request, input, output);
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeWriter::WriteData()
{
  isosurface::ControllerCommunicator ranks(this->Controller);
  isosurface::LocalVolume local;
  Status status;
  vtkImageData* image = this->GetInput();
  if (!this->FileName || !*this->FileName)
  {
    status = Status(StatusCode::InvalidArgument, "No file name is set.");
  }
  else if (image && image->GetNumberOfPoints() > 0)
  {
    int whole[6];
    image->GetExtent(whole);
    vtkInformation* inInfo = this->GetInputInformation();
    if (inInfo->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    {
      inInfo->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
    }
    local.Grid = isosurface::MakeGridGeometry(image, whole);
    local.Piece.Box = isosurface::MakeVertexBox(local.Grid, image->GetExtent());
    if (image->GetInformation()->Has(vtkDataObject::DATA_TIME_STEP()))
    {
      local.Time = { 1, image->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()) };
    }
    status = local.CollectArrays(image, true);
  }
  status = ranks.Agree(status);
  if (status.IsOk())
  {
    status = local.Agree(ranks);
  }
  if (status.IsOk())
  {
    isosurface::BlockedVolumeSettings settings;
    settings.BlockSize = this->BlockSize;
    settings.NumberOfStores = static_cast<std::uint32_t>(this->NumberOfStores);
    settings.Distribution = static_cast<isosurface::DistributionMethod>(this->Distribution);
    settings.RandomSeed = static_cast<std::uint64_t>(this->RandomSeed);
    settings.Compression.Codec = static_cast<isosurface::SegmentCodec>(this->Compression);
    settings.Compression.Level = this->CompressionLevel;
    if (local.Time[0] != 0)
    {
      settings.Time = local.Time[1];
    }
    std::unique_ptr<isosurface::SlabSource> source;
    if (this->MemoryLimit > 0)
    {
      settings.MemoryLimit = static_cast<std::uint64_t>(this->MemoryLimit) << 20;
      // The slice that is here is one of many that are asked for.
      local.Owners.clear();
      source = std::make_unique<isosurface::PipelineSource>(
        this->GetInputConnection(0, 0), this->GetInputInformation(), local.Grid, local.Arrays);
    }
    else
    {
      source = std::make_unique<isosurface::MemorySource>(local.Piece);
    }
    auto written = isosurface::BlockedVolumeWriter(ranks).Write(this->FileName, local.Grid,
      local.Arrays, *source, settings,
      [this](double share)
      {
        this->UpdateProgress(share);
        return !this->CheckAbort();
      });
    status = written.GetStatus();
    if (written.IsOk() && ranks.GetRank() == 0)
    {
      vtkLogF(INFO, "%s: %llu blocks of %d cells a side in %zu stores, %llu bytes", this->FileName,
        static_cast<unsigned long long>(written->Blocks), this->BlockSize, written->Stores.size(),
        static_cast<unsigned long long>(written->Bytes));
    }
  }
  if (!status.IsOk())
  {
    this->SetErrorCode(status.GetCode() == StatusCode::IoError ? vtkErrorCode::OutOfDiskSpaceError
                                                               : vtkErrorCode::UnknownError);
    if (status.GetCode() != StatusCode::Aborted)
    {
      vtkErrorMacro(<< status.GetMessage());
    }
  }
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "BlockSize: " << this->BlockSize << "\n";
  os << indent << "NumberOfStores: " << this->NumberOfStores << "\n";
  os << indent << "Distribution: " << this->Distribution << "\n";
  os << indent << "RandomSeed: " << this->RandomSeed << "\n";
  os << indent << "Compression: " << this->Compression << "\n";
  os << indent << "CompressionLevel: " << this->CompressionLevel << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
