// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeReader.h"

#include "BlockImage.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkInformationBlockedVolumeKey.h"

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

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Fingerprint.h"
#include "Storage/Sampling/BlockAssembly.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkBlockedVolumeReader);
vtkCxxSetObjectMacro(vtkBlockedVolumeReader, Controller, vtkMultiProcessController);

vtkInformationKeyMacro(vtkBlockedVolumeReader, BLOCKED_VOLUME, BlockedVolume);

namespace
{
constexpr std::uint64_t Mebibyte = 1024 * 1024;

using isosurface::Status;
using isosurface::StatusCode;

/// "1023 x 1023 x 1097"
std::string DescribeDimensions(const isosurface::GridGeometry& grid)
{
  const isosurface::Index3 dimensions = grid.GetDimensions();
  return std::to_string(dimensions[0]) + " x " + std::to_string(dimensions[1]) + " x " +
    std::to_string(dimensions[2]);
}

std::string DescribeLevel(const isosurface::GridGeometry& grid, int level)
{
  return level == 0 ? "all of it, " + DescribeDimensions(grid)
                    : "level " + std::to_string(level) + ", " +
      DescribeDimensions(grid.Coarsen(level)) + ", of " + DescribeDimensions(grid);
}
} // namespace

/// Fills an output with a piece of the volume. Not collective.
struct vtkBlockedVolumeReader::Reading
{
  vtkBlockedVolumeReader* Reader;
  isosurface::BlockedVolume& Volume;
  std::size_t Step;
  int Piece;
  int Pieces;
  int Threads;

  /// What decides about the output of all ranks.
  static std::vector<isosurface::CommonValue> MakeCommonValues(
    const vtkBlockedVolumeReader& reader, vtkInformation* outInfo);

  /// The image of one cell that stands for the volume.
  void MakeBox(vtkPartitionedDataSet* partitions) const;
  /// The slab of the piece at the finest level that fits MemoryLimit.
  Status ReadSlab(vtkPartitionedDataSet* partitions) const;
  static std::vector<std::size_t> FindEnabledArrays(const vtkBlockedVolumeReader& reader);
};

//------------------------------------------------------------------------------
vtkBlockedVolumeReader::vtkBlockedVolumeReader()
  : FileName(nullptr)
  , LocalStores(false)
  , MemoryLimit(256)
  , Level(0)
  , Controller(nullptr)
  , PointDataArraySelection(vtkSmartPointer<vtkDataArraySelection>::New())
  , Handle(vtkSmartPointer<vtkBlockedVolumeHandle>::New())
  , OpenTime(0)
  , IsErrorTold(false)
  , IsToldLate(false)
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
  const auto file = isosurface::GetLocalFileSystem().OpenForReading(fileName ? fileName : "");
  std::string head(
    file.IsOk() ? static_cast<std::size_t>(std::min<std::uint64_t>(4096, (*file)->GetSize())) : 0,
    '\0');
  if (head.empty() || !(*file)->Read(0, head.size(), &head[0]).IsOk())
  {
    return 0;
  }
  // The header's members are sorted, so the long lists of stores may stand before the format's
  // name; any part of a header that is large enough for that has its first members in here.
  return head[0] == '{' &&
    (head.find("ScalableIsosurface blocked volume") != std::string::npos ||
      (head.find("\"arrays\"") != std::string::npos &&
        head.find("\"blockSize\"") != std::string::npos));
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::SetLocalStores(bool local)
{
  if (this->LocalStores != local)
  {
    this->LocalStores = local;
    if (this->Handle && this->Handle->GetVolume())
    {
      this->Handle->GetVolume()->SetLocalStores(local);
    }
    this->Modified();
  }
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
    return this->Handle->GetStatus().IsOk();
  }
  this->OpenTime = this->Superclass::GetMTime();
  this->ShownText.clear();
  this->IsErrorTold = false;
  isosurface::Result<std::shared_ptr<isosurface::BlockedVolume>> volume =
    Status(StatusCode::NotFound, "No file name is set.");
  if (this->StandIn)
  {
    volume = this->StandIn->GetVolume();
  }
  else if (this->FileName && *this->FileName)
  {
    volume = isosurface::BlockedVolume::Open(this->FileName, isosurface::GetLocalFileSystem(),
      isosurface::BlockCache::GetProcessCache(), isosurface::OpenForeignVolume);
  }
  if (!volume.IsOk())
  {
    this->Handle->SetError(volume.GetStatus());
    this->IsErrorTold = true;
    vtkErrorMacro(<< volume.GetStatus().GetMessage());
    return false;
  }
  (*volume)->SetLocalStores(this->LocalStores);
  this->Handle->SetVolume(*volume);
  this->Handle->SetSampleText(this->StandIn ? this->StandInText : "");
  this->Handle->SetFinished(this->StandIn ? this->StandIn->GetFinished() : nullptr);
  return true;
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::SetStandIn(vtkBlockedVolumeHandle* standIn, const std::string& text)
{
  this->StandIn = standIn;
  this->StandInText = text;
  this->OpenTime = 0;
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  outInfo->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  outInfo->Remove(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
  outInfo->Remove(vtkStreamingDemandDrivenPipeline::TIME_RANGE());
  // An error on some ranks must not keep them from RequestData, where all ranks agree on it, nor
  // consumers from knowing that there is a blocked volume.
  this->BLOCKED_VOLUME()->Set(outInfo, this->Handle);
  this->IsToldLate = this->IsPending();
  if (this->IsToldLate || !this->OpenVolume())
  {
    return 1;
  }
  this->TellVolume(outInfo);
  return 1;
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::TellVolume(vtkInformation* outInfo)
{
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
  this->Handle->SetArrays(Reading::FindEnabledArrays(*this));

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
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector**, vtkInformationVector*)
{
  this->Handle->AskOutput();
  return 1;
}

//------------------------------------------------------------------------------
int vtkBlockedVolumeReader::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkPartitionedDataSet* partitions = vtkPartitionedDataSet::GetData(output, 0);
  partitions->Initialize();
  isosurface::ControllerCommunicator ranks(this->Controller);

  vtkInformation* outInfo = output->GetInformationObject(0);
  if (this->OpenVolume() && std::exchange(this->IsToldLate, false))
  {
    this->TellVolume(outInfo);
  }
  Status status = ranks.Agree(this->Handle->GetStatus(), Reading::MakeCommonValues(*this, outInfo));
  if (!status.IsOk())
  {
    // A consumer that takes blocks is not executed behind an error.
    this->Handle->EndTaking();
    if (!std::exchange(this->IsErrorTold, false))
    {
      vtkErrorMacro(<< status.GetMessage());
    }
    isosurface::SilenceFailure(output);
    return 0;
  }
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  const Reading reading = { this, *this->Handle->GetVolume(), this->Handle->FindTimeStep(outInfo),
    outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER()),
    std::max(1, outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES())), ranks.ChooseThreads(0) };
  if (const auto time = reading.Volume.GetHeader().TimeSteps[reading.Step].Time)
  {
    partitions->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *time);
  }
  const bool isBox = !this->Handle->IsOutputNeeded();
  status = isosurface::Attempt(reading.Volume.GetPath(),
    [&]
    {
      if (isBox)
      {
        reading.MakeBox(partitions);
      }
      return isBox ? Status::Ok() : reading.ReadSlab(partitions);
    });
  this->Handle->FinishOutput(isBox);
  if (!this->StandInText.empty())
  {
    this->ShownText = this->StandInText;
  }
  // Progress is told by one of the threads: a stop may have come when others did the last blocks.
  if (status.IsOk() && isosurface::IsAborted(*this))
  {
    status = Status(StatusCode::Aborted, "reading was aborted");
  }
  const auto news = reading.Volume.ShareStoreFaults(ranks);
  status = news.IsOk() ? ranks.Agree(status) : news.GetStatus();
  isosurface::ReportWarning(this, ranks, status, news.IsOk() ? news->Warning : "");
  if (!status.IsOk())
  {
    partitions->Initialize();
    if (status.GetCode() != StatusCode::Aborted)
    {
      this->Handle->EndTaking();
    }
  }
  return isosurface::EndExecution(this, output, status);
}

//------------------------------------------------------------------------------
std::vector<isosurface::CommonValue> vtkBlockedVolumeReader::Reading::MakeCommonValues(
  const vtkBlockedVolumeReader& reader, vtkInformation* outInfo)
{
  isosurface::Fingerprint properties;
  properties.AddNumber(static_cast<std::uint64_t>(reader.MemoryLimit));
  if (reader.Handle->GetVolume())
  {
    for (const std::size_t array : FindEnabledArrays(reader))
    {
      properties.AddNumber(array);
    }
  }
  return {
    reader.Handle->MakeCommonValue(),
    { reader.Handle->FindTimeStep(outInfo), "the ranks ask for different time steps" },
    { properties.Get(), "the properties of the reader are not the same on all ranks" },
  };
}

//------------------------------------------------------------------------------
std::vector<std::size_t> vtkBlockedVolumeReader::Reading::FindEnabledArrays(
  const vtkBlockedVolumeReader& reader)
{
  std::vector<std::size_t> enabled;
  const auto& arrays = reader.Handle->GetVolume()->GetHeader().Arrays;
  for (std::size_t array = 0; array < arrays.size(); ++array)
  {
    if (reader.PointDataArraySelection->ArrayIsEnabled(arrays[array].Name.c_str()))
    {
      enabled.push_back(array);
    }
  }
  return enabled;
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::Reading::MakeBox(vtkPartitionedDataSet* partitions) const
{
  this->Reader->ShownText = "nothing yet, of " + DescribeDimensions(this->Volume.GetHeader().Grid);
  // Whoever asks for information (ParaView's panels) learns the bounds, arrays and ranges.
  if (this->Piece == 0)
  {
    partitions->SetNumberOfPartitions(1);
    partitions->SetPartition(0, isosurface::MakeBox(this->Volume, this->Step));
  }
}

//------------------------------------------------------------------------------
Status vtkBlockedVolumeReader::Reading::ReadSlab(vtkPartitionedDataSet* partitions) const
{
  vtkBlockedVolumeReader* reader = this->Reader;
  const std::vector<std::size_t> arrays = FindEnabledArrays(*reader);
  const std::optional<int> level =
    isosurface::FindLevelWithin(this->Volume, arrays, this->Pieces, reader->MemoryLimit * Mebibyte);
  if (!level)
  {
    vtkWarningWithObjectMacro(reader, << reader->FileName
                                      << ": not even the coarsest level fits the memory limit of "
                                      << reader->MemoryLimit << " MiB: the output is empty.");
    return Status::Ok();
  }
  reader->Level = *level;
  reader->ShownText = DescribeLevel(this->Volume.GetHeader().Grid, *level);
  const isosurface::BlockBox slab =
    isosurface::PartitionBlocks(*this->Volume.FindLevel(*level).Grid, this->Piece, this->Pieces);
  if (slab.IsEmpty())
  {
    return Status::Ok();
  }
  isosurface::QueryStatistics statistics;
  const auto part = isosurface::ReadSlab(this->Volume, slab, this->Step, arrays, *level,
    this->Threads, statistics, isosurface::MakeProgress(*reader));
  ISOSURFACE_RETURN_IF_ERROR(part.GetStatus());
  partitions->SetNumberOfPartitions(1);
  partitions->SetPartition(0, *part);
  vtkLogF(1,
    "%s: piece %d of %d: level %d: %llu blocks read, %llu from the cache, %llu bytes read, "
    "%.4f s",
    reader->FileName, this->Piece, this->Pieces, *level,
    static_cast<unsigned long long>(statistics.BlocksRead),
    static_cast<unsigned long long>(statistics.BlockCacheHits),
    static_cast<unsigned long long>(statistics.BytesRead), statistics.ReadSeconds);
  return Status::Ok();
}

//------------------------------------------------------------------------------
void vtkBlockedVolumeReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << " MiB\n";
  os << indent << "LocalStores: " << this->LocalStores << "\n";
  os << indent << "CacheSize: " << this->GetCacheSize() << " MiB\n";
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
  os << indent << "PointDataArraySelection:\n";
  this->PointDataArraySelection->PrintSelf(os, indent.GetNextIndent());
}
