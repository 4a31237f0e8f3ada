// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeReader.h"

#include "BlockImage.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationStabbingRequestKey.h"
#include "vtkStabbingRequest.h"

#include "vtkDataArraySelection.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSet.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Base/ParallelFor.h"
#include "ControllerCommunicator.h"
#include "Store/BlockedVolume.h"

#include <algorithm>
#include <fstream>
#include <vector>

vtkStandardNewMacro(vtkBlockedVolumeReader);
vtkCxxSetObjectMacro(vtkBlockedVolumeReader, Controller, vtkMultiProcessController);

vtkInformationKeyMacro(vtkBlockedVolumeReader, BLOCKED_VOLUME, BlockedVolume);
vtkInformationKeyMacro(vtkBlockedVolumeReader, STABBING_REQUEST, StabbingRequest);

namespace
{
constexpr std::uint64_t Mebibyte = 1024 * 1024;

using isosurface::Status;
using isosurface::StatusCode;

/// The finest level of which a piece's part of the arrays fits the limit; -1 if none does.
int ChooseLevel(const isosurface::BlockedVolume& volume, const std::vector<std::size_t>& arrays,
  int pieces, std::uint64_t limit)
{
  for (int level = 0; level < volume.GetNumberOfLevels(); ++level)
  {
    std::uint64_t bytes = 0;
    for (const std::size_t array : arrays)
    {
      const auto components =
        static_cast<std::uint64_t>(volume.GetHeader().Arrays[array].Components);
      bytes += components * volume.EstimateBytes(volume.GetVariables().GetFirst(array), level) /
        static_cast<std::uint64_t>(pieces);
    }
    if (bytes <= limit)
    {
      return level;
    }
  }
  return -1;
}

/// The array of a request; without a name the one that becomes the active scalars.
std::optional<std::size_t> FindAskedArray(const isosurface::BlockedVolumeHeader& header,
  const std::vector<std::size_t>& enabled, const std::string& name)
{
  if (name.empty())
  {
    return enabled.empty() ? std::nullopt : std::make_optional(enabled.front());
  }
  return header.FindArray(name);
}
} // namespace

//------------------------------------------------------------------------------
vtkBlockedVolumeReader::vtkBlockedVolumeReader()
  : FileName(nullptr)
  , MemoryLimit(256)
  , Level(0)
  , Controller(nullptr)
  , PointDataArraySelection(vtkSmartPointer<vtkDataArraySelection>::New())
  , OpenTime(0)
{
  this->SetNumberOfInputPorts(0);
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

//------------------------------------------------------------------------------
vtkBlockedVolumeReader::~vtkBlockedVolumeReader()
{
  this->SetFileName(nullptr);
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::CanReadFile(const char* fileName)
{
  std::ifstream file(fileName ? fileName : "", std::ios::binary);
  std::string head(4096, '\0');
  file.read(&head[0], static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  // The header's members are sorted, so the long lists of stores may stand before the format's
  // name; any part of a header that is large enough for that has its first members in here.
  return !head.empty() && head[0] == '{' &&
    (head.find("ScalableIsosurface blocked volume") != std::string::npos ||
      (head.find("\"arrays\"") != std::string::npos &&
        head.find("\"blockSize\"") != std::string::npos));
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::SetCacheSize(int mebibytes)
{
  const std::uint64_t bytes = static_cast<std::uint64_t>(std::max(0, mebibytes)) * Mebibyte;
  // No Modified(): the size of the cache changes no output.
  isosurface::BlockCache::GetProcessCache()->SetBudget(bytes);
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::GetCacheSize()
{
  return static_cast<int>(isosurface::BlockCache::GetProcessCache()->GetBudget() / Mebibyte);
}

//------------------------------------------------------------------------------
vtkDataArraySelection* vtkBlockedVolumeReader::GetPointDataArraySelection()
{
  return this->PointDataArraySelection;
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::GetNumberOfPointArrays()
{
  return this->PointDataArraySelection->GetNumberOfArrays();
}

//------------------------------------------------------------------------------
const char* vtkBlockedVolumeReader::GetPointArrayName(int index)
{
  return this->PointDataArraySelection->GetArrayName(index);
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::GetPointArrayStatus(const char* name)
{
  return this->PointDataArraySelection->ArrayIsEnabled(name);
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::SetPointArrayStatus(const char* name, int status)
{
  this->PointDataArraySelection->SetArraySetting(name, status);
}

//------------------------------------------------------------------------------
vtkMTimeType vtkBlockedVolumeReader::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->PointDataArraySelection->GetMTime());
}

//------------------------------------------------------------------------------
bool vtkBlockedVolumeReader::OpenVolume()
{
  if (this->OpenTime == this->Superclass::GetMTime())
  {
    return this->Handle != nullptr;
  }
  this->OpenTime = this->Superclass::GetMTime();
  this->Handle = nullptr;
  this->ReportedError.clear();
  if (!this->FileName || !*this->FileName)
  {
    this->ReportedError = "No file name is set.";
    vtkErrorMacro(<< this->ReportedError);
    return false;
  }
  auto volume = isosurface::BlockedVolume::Open(this->FileName);
  if (!volume.IsOk())
  {
    this->ReportedError = volume.GetStatus().GetMessage();
    vtkErrorMacro(<< this->ReportedError);
    return false;
  }
  this->Handle = vtkSmartPointer<vtkBlockedVolumeHandle>::New();
  this->Handle->SetVolume(*volume);
  return true;
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  outInfo->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  outInfo->Remove(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
  outInfo->Remove(vtkStreamingDemandDrivenPipeline::TIME_RANGE());
  if (!this->STABBING_REQUEST()->Has(outInfo))
  {
    vtkNew<vtkStabbingRequest> nothing;
    this->STABBING_REQUEST()->Set(outInfo, nothing);
  }
  // A failure on some ranks must not keep them from RequestData, where all ranks agree on it.
  if (!this->OpenVolume())
  {
    outInfo->Remove(this->BLOCKED_VOLUME());
    return 1;
  }
  this->BLOCKED_VOLUME()->Set(outInfo, this->Handle);

  const isosurface::BlockedVolumeHeader& header = this->Handle->GetVolume()->GetHeader();
  for (const isosurface::ArrayDescription& array : header.Arrays)
  {
    this->PointDataArraySelection->AddArray(array.Name.c_str());
  }
  for (int index = this->PointDataArraySelection->GetNumberOfArrays() - 1; index >= 0; --index)
  {
    if (!header.FindArray(this->PointDataArraySelection->GetArrayName(index)))
    {
      this->PointDataArraySelection->RemoveArrayByIndex(index);
    }
  }

  std::vector<double> times;
  for (const isosurface::TimeStepDescription& step : header.TimeSteps)
  {
    if (step.Time)
    {
      times.push_back(*step.Time);
    }
  }
  if (!times.empty())
  {
    const double range[2] = { times.front(), times.back() };
    outInfo->Set(
      vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
    outInfo->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), range, 2);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkPartitionedDataSet* partitions = vtkPartitionedDataSet::GetData(output, 0);
  partitions->Initialize();
  isosurface::ControllerCommunicator ranks(this->Controller);

  const bool open = this->OpenVolume();
  Status status = open ? Status::Ok() : Status(StatusCode::NotFound, this->ReportedError);
  status = ranks.Agree(status);
  if (!status.IsOk())
  {
    if (open)
    {
      vtkErrorMacro(<< status.GetMessage());
    }
    return 0;
  }
  const int ranksOnNode = ranks.GetRanksOnNode();
  status = this->ReadBlocks(
    output->GetInformationObject(0), isosurface::ChooseThreadCount(ranksOnNode), partitions);
  // Progress is told by one of the threads: a stop may have come when others did the last blocks.
  if (status.IsOk() && this->CheckAbort())
  {
    status = Status(StatusCode::Aborted, "reading was stopped");
  }
  status = ranks.Agree(status);
  if (status.GetCode() == StatusCode::Aborted)
  {
    partitions->Initialize();
    return 1;
  }
  if (!status.IsOk())
  {
    partitions->Initialize();
    vtkErrorMacro(<< status.GetMessage());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
isosurface::Status vtkBlockedVolumeReader::ReadBlocks(
  vtkInformation* outInfo, int threads, vtkPartitionedDataSet* partitions)
{
  isosurface::BlockedVolume& volume = *this->Handle->GetVolume();
  const isosurface::BlockedVolumeHeader& header = volume.GetHeader();
  const std::size_t step = this->Handle->FindTimeStep(outInfo);
  const int piece = outInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER());
  const int pieces =
    std::max(1, outInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES()));

  std::vector<std::size_t> arrays;
  for (std::size_t array = 0; array < header.Arrays.size(); ++array)
  {
    if (this->PointDataArraySelection->ArrayIsEnabled(header.Arrays[array].Name.c_str()))
    {
      arrays.push_back(array);
    }
  }

  if (header.TimeSteps[step].Time)
  {
    partitions->GetInformation()->Set(
      vtkDataObject::DATA_TIME_STEP(), *header.TimeSteps[step].Time);
  }
  vtkStabbingRequest* request = this->STABBING_REQUEST()->GetRequest(outInfo);
  if (request && request->GetHandleOnly())
  {
    // The consumer takes its blocks itself. Whoever else asks for information (ParaView's panels)
    // learns the bounds, arrays and ranges.
    if (piece == 0)
    {
      partitions->SetNumberOfPartitions(1);
      partitions->SetPartition(0, isosurface::MakeBoxImage(volume, step));
    }
    return Status::Ok();
  }

  isosurface::QueryStatistics statistics;
  const auto asked = request && !request->GetIsovalues().empty()
    ? FindAskedArray(header, arrays, request->GetArrayName())
    : std::optional<std::size_t>();
  const auto variable = asked ? volume.GetVariables().FindChoice(*asked, request->GetComponent())
                              : std::optional<std::size_t>();
  if (variable)
  {
    if (std::find(arrays.begin(), arrays.end(), *asked) == arrays.end())
    {
      arrays.push_back(*asked);
    }
    const int level = std::clamp(request->GetLevel(), 0, volume.GetNumberOfLevels() - 1);
    auto active = volume.FindActiveBlocks(step, *variable, request->GetIsovalues(), piece, pieces,
      statistics, level, request->GetSelection());
    if (!active.IsOk())
    {
      return active.GetStatus();
    }
    ISOSURFACE_RETURN_IF_ERROR(
      this->ReadActiveBlocks(*active, step, arrays, level, threads, partitions, statistics));
  }
  else
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->ReadSlab(piece, pieces, step, arrays, threads, partitions, statistics));
  }
  vtkLogF(INFO,
    "%s: piece %d of %d: level %d: %llu blocks read, %llu from the cache, %llu bytes read, "
    "%llu tree pages read, query %.4f s, read %.4f s",
    this->FileName, piece, pieces, this->Level,
    static_cast<unsigned long long>(statistics.BlocksRead),
    static_cast<unsigned long long>(statistics.BlockCacheHits),
    static_cast<unsigned long long>(statistics.BytesRead),
    static_cast<unsigned long long>(statistics.TreePagesRead), statistics.QuerySeconds,
    statistics.ReadSeconds);
  return Status::Ok();
}

//------------------------------------------------------------------------------
bool vtkBlockedVolumeReader::TellProgress(double share)
{
  this->UpdateProgress(share);
  return !this->CheckAbort();
}

//------------------------------------------------------------------------------
isosurface::Status vtkBlockedVolumeReader::ReadSlab(int piece, int pieces, std::size_t step,
  const std::vector<std::size_t>& arrays, int threads, vtkPartitionedDataSet* partitions,
  isosurface::QueryStatistics& statistics)
{
  isosurface::BlockedVolume& volume = *this->Handle->GetVolume();
  const int level = ChooseLevel(volume, arrays, pieces, this->MemoryLimit * Mebibyte);
  if (level < 0)
  {
    vtkWarningMacro(<< this->FileName << ": not even the coarsest level fits the memory limit of "
                    << this->MemoryLimit << " MiB: the output is empty.");
    return Status::Ok();
  }
  this->Level = level;
  const isosurface::BlockBox slab =
    isosurface::PartitionBlocks(*volume.FindLevel(level).Grid, piece, pieces);
  if (slab.IsEmpty())
  {
    return Status::Ok();
  }
  const auto image = isosurface::ReadSlabImage(volume, slab, step, arrays, level, threads,
    statistics, [this](double share) { return this->TellProgress(share); });
  if (!image.IsOk())
  {
    return image.GetStatus();
  }
  partitions->SetNumberOfPartitions(1);
  partitions->SetPartition(0, *image);
  return Status::Ok();
}

//------------------------------------------------------------------------------
isosurface::Status vtkBlockedVolumeReader::ReadActiveBlocks(
  const std::vector<isosurface::BlockReference>& blocks, std::size_t step,
  const std::vector<std::size_t>& arrays, int level, int threads, vtkPartitionedDataSet* partitions,
  isosurface::QueryStatistics& statistics)
{
  isosurface::BlockedVolume& volume = *this->Handle->GetVolume();
  this->Level = level;
  std::vector<vtkSmartPointer<vtkImageData>> images(blocks.size());
  std::vector<isosurface::QueryStatistics> costs(static_cast<std::size_t>(threads));
  std::vector<Status> failures(static_cast<std::size_t>(threads));
  const bool finished = isosurface::ParallelFor(
    blocks.size(), threads,
    [&](std::size_t index, int thread)
    {
      if (failures[thread].IsOk())
      {
        auto image =
          isosurface::ReadBlockImage(volume, blocks[index], step, arrays, level, costs[thread]);
        if (image.IsOk())
        {
          images[index] = *image;
        }
        else
        {
          failures[thread] = image.GetStatus();
        }
      }
    },
    [this](double share) { return this->TellProgress(share); });
  for (const isosurface::QueryStatistics& cost : costs)
  {
    statistics.Add(cost);
  }
  for (const Status& failure : failures)
  {
    ISOSURFACE_RETURN_IF_ERROR(failure);
  }
  if (!finished)
  {
    return Status(StatusCode::Aborted, "reading was stopped");
  }
  partitions->SetNumberOfPartitions(static_cast<unsigned int>(images.size()));
  for (std::size_t index = 0; index < images.size(); ++index)
  {
    partitions->SetPartition(static_cast<unsigned int>(index), images[index]);
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << " MiB\n";
  os << indent << "CacheSize: " << this->GetCacheSize() << " MiB\n";
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
  os << indent << "PointDataArraySelection:\n";
  this->PointDataArraySelection->PrintSelf(os, indent.GetNextIndent());
}
