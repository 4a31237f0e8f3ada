// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeWriter.h"

#include "vtkDataArray.h"
#include "vtkErrorCode.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"

#include "ControllerCommunicator.h"
#include "ImageSamples.h"
#include "Store/BlockedVolumeWriter.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkBlockedVolumeWriter);
vtkCxxSetObjectMacro(vtkBlockedVolumeWriter, Controller, vtkMultiProcessController);

namespace
{
using isosurface::Message;
using isosurface::Status;
using isosurface::StatusCode;

/// What this rank has of the volume; arrays in the order of `arrays`, all of one component.
struct LocalVolume
{
  isosurface::GridGeometry Grid;
  std::array<double, 2> Time{ 0, 0 }; ///< 1 and the time, if there is one
  std::vector<isosurface::ArrayDescription> Arrays;
  isosurface::VolumePiece Piece;
  std::vector<vtkSmartPointer<vtkDataArray>> Owners;
};

Status CollectArrays(vtkImageData* image, LocalVolume& local)
{
  vtkPointData* points = image->GetPointData();
  // The active scalars come first: they decide which store a block goes to.
  std::vector<vtkDataArray*> arrays;
  if (vtkDataArray* scalars = points->GetScalars())
  {
    arrays.push_back(scalars);
  }
  for (int index = 0; index < points->GetNumberOfArrays(); ++index)
  {
    vtkDataArray* array = points->GetArray(index);
    if (array && array != points->GetScalars() && array != image->GetPointGhostArray())
    {
      arrays.push_back(array);
    }
  }
  for (vtkDataArray* array : arrays)
  {
    const auto type = isosurface::GetValueTypeOf(array);
    if (array->GetNumberOfComponents() != 1 || !type.IsOk())
    {
      vtkLogF(WARNING, "array \"%s\" is left out: only numeric arrays of one component are written",
        array->GetName() ? array->GetName() : "");
      continue;
    }
    auto samples = isosurface::MakeImageSamples(local.Grid, image, array);
    if (!samples.IsOk())
    {
      return samples.GetStatus();
    }
    const char* name = array->GetName();
    local.Arrays.push_back({ name && *name ? name : "scalars", *type });
    // A writer needs what there is, ghosts included: they are samples like all others.
    samples->View.Box = samples->View.Available;
    local.Piece.Arrays.push_back(samples->View);
    local.Owners.push_back(samples->Array);
  }
  if (local.Arrays.empty())
  {
    return Status(StatusCode::InvalidArgument,
      "the input has no numeric point array of one component to write");
  }
  return Status::Ok();
}

Message Describe(const LocalVolume& local)
{
  std::string text;
  auto add = [&text](const auto& values)
  { text.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])); };
  add(local.Grid.Extent);
  add(local.Grid.Origin);
  add(local.Grid.Spacing);
  add(local.Grid.Direction);
  add(local.Time);
  for (const isosurface::ArrayDescription& array : local.Arrays)
  {
    text += isosurface::GetValueTypeName(array.Type) + std::string("\n") + array.Name + '\0';
  }
  return Message(text.begin(), text.end());
}

/**
 * Makes all ranks speak of the same volume: a rank without any part of it learns grid and arrays
 * from the others; ranks that have different ideas of them get an error.
 */
Status AgreeOnVolume(isosurface::Communicator& ranks, LocalVolume& local)
{
  const bool hasPart = !local.Piece.Box.IsEmpty();
  const std::vector<Message> all = ranks.AllGather(hasPart ? Describe(local) : Message());
  const auto first =
    std::find_if(all.begin(), all.end(), [](const Message& text) { return !text.empty(); });
  if (first == all.end())
  {
    return Status(StatusCode::InvalidArgument, "the input is empty");
  }
  for (const Message& text : all)
  {
    if (!text.empty() && text != *first)
    {
      return Status(StatusCode::InvalidArgument,
        "the ranks' pieces differ in whole extent, origin, spacing, direction, time or arrays");
    }
  }
  if (!hasPart)
  {
    const char* from = reinterpret_cast<const char*>(first->data());
    const char* end = from + first->size();
    auto take = [&from](auto& values)
    {
      const std::size_t bytes = values.size() * sizeof(values[0]);
      std::copy(from, from + bytes, reinterpret_cast<char*>(values.data()));
      from += bytes;
    };
    take(local.Grid.Extent);
    take(local.Grid.Origin);
    take(local.Grid.Spacing);
    take(local.Grid.Direction);
    take(local.Time);
    local.Arrays.clear();
    while (from != end)
    {
      const char* line = std::find(from, end, '\n');
      const char* stop = std::find(line, end, '\0');
      local.Arrays.push_back(
        { std::string(line + 1, stop), *isosurface::FindValueType(std::string(from, line)) });
      from = stop + 1;
    }
    local.Piece = {};
    for (const isosurface::ArrayDescription& array : local.Arrays)
    {
      local.Piece.Arrays.emplace_back();
      local.Piece.Arrays.back().Type = array.Type;
    }
  }
  return Status::Ok();
}
} // namespace

//------------------------------------------------------------------------------
vtkBlockedVolumeWriter::vtkBlockedVolumeWriter()
  : FileName(nullptr)
  , BlockSize(32)
  , NumberOfStores(0)
  , Distribution(GREEDY)
  , RandomSeed(0)
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
  if (request->Has(vtkStreamingDemandDrivenPipeline::REQUEST_UPDATE_EXTENT()) && this->Controller)
  {
    vtkInformation* inInfo = input[0]->GetInformationObject(0);
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
  LocalVolume local;
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
    status = CollectArrays(image, local);
  }
  status = ranks.Agree(status);
  if (status.IsOk())
  {
    status = AgreeOnVolume(ranks, local);
  }
  if (status.IsOk())
  {
    isosurface::BlockedVolumeSettings settings;
    settings.BlockSize = this->BlockSize;
    settings.NumberOfStores = static_cast<std::uint32_t>(this->NumberOfStores);
    settings.Distribution = static_cast<isosurface::DistributionMethod>(this->Distribution);
    settings.RandomSeed = static_cast<std::uint64_t>(this->RandomSeed);
    if (local.Time[0] != 0)
    {
      settings.Time = local.Time[1];
    }
    auto written = isosurface::BlockedVolumeWriter(ranks).Write(this->FileName, local.Grid,
      local.Arrays, local.Piece, settings,
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
  os << indent << "Controller: " << this->Controller << "\n";
}
