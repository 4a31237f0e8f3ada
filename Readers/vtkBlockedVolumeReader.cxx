// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeReader.h"

#include "BlockImage.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkInformationBlockedVolumeKey.h"

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
#include "Ground/Base/BackgroundTask.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/PrintableText.h"
#include "Ground/Volume/GridPlace.h"
#include "ImageSamples.h"
#include "Storage/Sampling/BlockAssembly.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <cmath>
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

std::vector<std::size_t> FindEnabledArrays(
  const isosurface::BlockedVolumeHeader& header, vtkDataArraySelection& selection)
{
  std::vector<std::size_t> enabled;
  for (std::size_t array = 0; array < header.Arrays.size(); ++array)
  {
    if (selection.ArrayIsEnabled(header.Arrays[array].Name.c_str()))
    {
      enabled.push_back(array);
    }
  }
  return enabled;
}

constexpr const char* UnknownUnit = "unknown";

/// Nothing, or three numbers.
isosurface::Result<std::optional<std::array<double, 3>>> TakeThree(
  const std::string& path, const char* name, const std::vector<double>& numbers)
{
  if (!numbers.empty() && numbers.size() != 3)
  {
    return Status(StatusCode::InvalidArgument,
      path + ": " + name + " has " + std::to_string(numbers.size()) + " numbers in place of 3");
  }
  return numbers.empty() ? std::optional<std::array<double, 3>>()
                         : std::array<double, 3>{ numbers[0], numbers[1], numbers[2] };
}

void TellTimes(const std::vector<double>& times, vtkInformation* outInfo)
{
  if (!times.empty())
  {
    const double range[2] = { times.front(), times.back() };
    outInfo->Set(
      vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
    outInfo->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), range, 2);
  }
}
} // namespace

/// Fills an output with a piece of the volume. Not collective.
struct vtkBlockedVolumeReader::Reading
{
  vtkBlockedVolumeReader* Reader;
  std::shared_ptr<isosurface::BlockedVolume> Volume;
  std::vector<std::size_t> Arrays;
  std::size_t Step;
  int Piece;
  int Pieces;
  int Threads;

  /// What is asked for of the handle's volume.
  Reading(vtkBlockedVolumeReader& reader, const vtkBlockedVolumeHandle& handle,
    vtkInformation* outInfo, int threads);
  /// What decides about the output of all ranks.
  static std::vector<isosurface::CommonValue> MakeCommonValues(
    const vtkBlockedVolumeReader& reader, vtkInformation* outInfo);

  /// The image of one cell that stands for the volume.
  void MakeBox(vtkPartitionedDataSet* partitions) const;
  /// The slab of the piece at the finest level that fits MemoryLimit.
  Status MakeSlab(vtkPartitionedDataSet* partitions) const;

  std::optional<int> FindLevel() const;
  /// Begins to read the slab beside the calling thread; null if there is none.
  std::unique_ptr<PreparedOutput> PrepareSlab() const;
  /// Null if the slab is empty.
  isosurface::Result<vtkSmartPointer<vtkDataSet>> ReadSlab(
    int level, const isosurface::Progress& progress) const;
  /// Tells slabs apart.
  std::uint64_t ComputeFingerprint(int level) const;
};

/// A slab that is read beside the calling thread.
struct vtkBlockedVolumeReader::PreparedOutput
{
  std::uint64_t Fingerprint;
  vtkSmartPointer<vtkDataSet> Slab;                 ///< the thread's until it has ended
  std::unique_ptr<isosurface::BackgroundTask> Work; ///< the last member: it uses the others
};

vtkBlockedVolumeReader::vtkBlockedVolumeReader()
  : PointDataArraySelection(vtkSmartPointer<vtkDataArraySelection>::New())
  , Handle(vtkSmartPointer<vtkBlockedVolumeHandle>::New())
{
  this->TellGrid({});
  this->SetNumberOfInputPorts(0);
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkBlockedVolumeReader::~vtkBlockedVolumeReader()
{
  this->SetFileName(nullptr);
  this->SetLengthUnit(nullptr);
  this->SetController(nullptr);
}

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

void vtkBlockedVolumeReader::SetCacheSize(int mebibytes)
{
  const std::uint64_t bytes = static_cast<std::uint64_t>(std::max(0, mebibytes)) * Mebibyte;
  // No Modified(): the size of the cache changes no output.
  isosurface::BlockCache::GetProcessCache()->SetBudget(bytes);
}

int vtkBlockedVolumeReader::GetCacheSize()
{
  return static_cast<int>(isosurface::BlockCache::GetProcessCache()->GetBudget() / Mebibyte);
}

void vtkBlockedVolumeReader::Change(
  std::vector<double>& numbers, std::vector<double> kept, const std::vector<double>& added)
{
  kept.insert(kept.end(), added.begin(), added.end());
  if (numbers != kept)
  {
    numbers = std::move(kept);
    this->Modified();
  }
}

Status vtkBlockedVolumeReader::MakePlace(
  const std::string& path, isosurface::GridPlace& place) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(place.Spacing, TakeThree(path, "Spacing", this->Spacing));
  ISOSURFACE_ASSIGN_OR_RETURN(place.Origin, TakeThree(path, "Origin", this->Origin));
  const std::string unit = this->LengthUnit ? this->LengthUnit : "";
  if (!unit.empty())
  {
    place.Unit = isosurface::FindLengthUnit(unit);
    if (place.Unit == isosurface::LengthUnit::Unknown && unit != UnknownUnit)
    {
      return Status(StatusCode::InvalidArgument,
        path + ": LengthUnit: \"" + unit + "\" is no unit of length, as m, mm, um or inch");
    }
  }
  return place.Check(path);
}

void vtkBlockedVolumeReader::TellGrid(const isosurface::GridGeometry& grid)
{
  std::transform(grid.Spacing.begin(), grid.Spacing.end(), this->FoundSpacing,
    [](double distance) { return std::abs(distance); });
  std::copy(grid.Origin.begin(), grid.Origin.end(), this->FoundOrigin);
  this->FoundUnit = grid.Unit == isosurface::LengthUnit::Unknown
    ? UnknownUnit
    : isosurface::GetLengthUnitName(grid.Unit);
}

vtkMTimeType vtkBlockedVolumeReader::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->PointDataArraySelection->GetMTime());
}

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
    isosurface::GridPlace place;
    const Status placed = this->MakePlace(this->FileName, place);
    volume = placed.IsOk()
      ? isosurface::BlockedVolume::Open(this->FileName, isosurface::GetLocalFileSystem(),
          isosurface::BlockCache::GetProcessCache(), isosurface::OpenForeignVolume, place)
      : placed;
  }
  if (!volume.IsOk())
  {
    this->Handle->SetError(volume.GetStatus());
    this->IsErrorTold = true;
    vtkErrorMacro(<< isosurface::MakePrintable(volume.GetStatus().GetMessage()));
    return false;
  }
  (*volume)->SetLocalStores(this->LocalStores);
  this->Handle->SetVolume(*volume);
  const bool isSample = this->StandIn && !this->StandIn->GetSampleText().empty();
  this->Handle->SetSample(isSample ? this->StandIn->GetSampleText() : "",
    isSample ? this->StandIn->GetSampled() : "", isSample ? this->StandIn->GetSampleShare() : 1);
  this->Handle->SetFinished(isSample ? this->StandIn->GetFinished() : nullptr);
  if (!isSample)
  {
    this->TellGrid((*volume)->GetFoundGrid());
  }
  return true;
}

void vtkBlockedVolumeReader::SetStandIn(vtkBlockedVolumeHandle* standIn)
{
  this->StandIn = standIn;
  this->OpenTime = 0;
}

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
  if (this->IsToldLate)
  {
    TellTimes(this->SourceTimes, outInfo);
    return 1;
  }
  if (!this->OpenVolume())
  {
    return 1;
  }
  this->TellVolume(outInfo);
  return 1;
}

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
  this->Handle->SetArrays(FindEnabledArrays(header, *this->PointDataArraySelection));

  if (!this->Handle->GetSampleText().empty())
  {
    TellTimes(this->SourceTimes, outInfo);
    return;
  }
  std::vector<double> times;
  for (const isosurface::TimeStepDescription& step : header.TimeSteps)
  {
    if (step.Time)
    {
      times.push_back(*step.Time);
    }
  }
  TellTimes(times, outInfo);
}

int vtkBlockedVolumeReader::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector**, vtkInformationVector*)
{
  this->Handle->AskOutput();
  return 1;
}

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
      vtkErrorMacro(<< isosurface::MakePrintable(status.GetMessage()));
    }
    isosurface::MarkFailure(output);
    return 0;
  }
  const Reading reading(*this, *this->Handle, outInfo, ranks.ChooseThreads(0));
  if (const auto time = reading.Volume->GetHeader().TimeSteps[reading.Step].Time)
  {
    partitions->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), *time);
  }
  // Filters hand on the field data of the composite, and not that of its parts.
  isosurface::StoreLengthUnit(partitions, reading.Volume->GetHeader().Grid.Unit);
  for (const isosurface::ArrayDescription& array : reading.Volume->GetHeader().Arrays)
  {
    isosurface::StoreUnit(partitions, array.Name, array.Unit);
  }
  const bool isBox = !this->Handle->IsOutputNeeded();
  status = isosurface::Attempt(reading.Volume->GetPath(),
    [&]
    {
      if (isBox)
      {
        reading.MakeBox(partitions);
      }
      return isBox ? Status::Ok() : reading.MakeSlab(partitions);
    });
  this->Prepared.reset();
  this->Handle->FinishOutput(isBox);
  if (!this->Handle->GetSampleText().empty())
  {
    this->ShownText = this->Handle->GetSampleText();
  }
  // Progress is told by one of the threads: a stop may have come when others did the last blocks.
  if (status.IsOk() && isosurface::IsAborted(*this))
  {
    status = Status(StatusCode::Aborted, "reading was aborted");
  }
  const auto news = reading.Volume->ShareStoreFaults(ranks);
  status = news.IsOk() ? ranks.Agree(status) : news.GetStatus();
  isosurface::ReportWarning(this, ranks, status, news.IsOk() ? news->Warning : "");
  if (!status.IsOk() && status.GetCode() != StatusCode::Aborted)
  {
    this->Handle->EndTaking();
  }
  return isosurface::EndExecution(this, output, status);
}

std::vector<isosurface::CommonValue> vtkBlockedVolumeReader::Reading::MakeCommonValues(
  const vtkBlockedVolumeReader& reader, vtkInformation* outInfo)
{
  isosurface::Fingerprint grid;
  grid.AddReals(reader.Spacing);
  grid.AddReals(reader.Origin);
  grid.AddText(reader.LengthUnit ? reader.LengthUnit : "");
  isosurface::Fingerprint properties;
  properties.AddNumber(static_cast<std::uint64_t>(reader.MemoryLimit));
  if (reader.Handle->GetVolume())
  {
    for (const std::size_t array : reader.Handle->GetArrays())
    {
      properties.AddNumber(array);
    }
  }
  return {
    { grid.Get(), "Spacing, Origin and LengthUnit of the reader are not the same on all ranks" },
    reader.Handle->MakeCommonValue(),
    { reader.Handle->FindTimeStep(outInfo), "the ranks ask for different time steps" },
    { properties.Get(), "the properties of the reader are not the same on all ranks" },
  };
}

vtkBlockedVolumeReader::Reading::Reading(vtkBlockedVolumeReader& reader,
  const vtkBlockedVolumeHandle& handle, vtkInformation* outInfo, int threads)
  : Reader(&reader)
  , Volume(handle.GetVolume())
  , Arrays(FindEnabledArrays(this->Volume->GetHeader(), *reader.PointDataArraySelection))
  , Step(handle.FindTimeStep(outInfo))
  , Piece(outInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()))
  , Pieces(std::max(1, outInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES())))
  , Threads(threads)
{
}

void vtkBlockedVolumeReader::Reading::MakeBox(vtkPartitionedDataSet* partitions) const
{
  this->Reader->ShownText = "nothing yet, of " + DescribeDimensions(this->Volume->GetHeader().Grid);
  // Whoever asks for information (ParaView's panels) learns the bounds, arrays and ranges.
  if (this->Piece == 0)
  {
    partitions->SetNumberOfPartitions(1);
    partitions->SetPartition(0, isosurface::MakeBox(*this->Volume, this->Step));
  }
}

std::optional<int> vtkBlockedVolumeReader::Reading::FindLevel() const
{
  return isosurface::FindLevelWithin(
    *this->Volume, this->Arrays, this->Pieces, this->Reader->MemoryLimit * Mebibyte);
}

std::uint64_t vtkBlockedVolumeReader::Reading::ComputeFingerprint(int level) const
{
  isosurface::Fingerprint fingerprint;
  fingerprint.AddNumber(this->Volume->GetFingerprint());
  fingerprint.AddNumber(this->Step);
  fingerprint.AddNumber(static_cast<std::uint64_t>(this->Piece));
  fingerprint.AddNumber(static_cast<std::uint64_t>(this->Pieces));
  fingerprint.AddNumber(static_cast<std::uint64_t>(level));
  for (const std::size_t array : this->Arrays)
  {
    fingerprint.AddNumber(array);
  }
  return fingerprint.Get();
}

isosurface::Result<vtkSmartPointer<vtkDataSet>> vtkBlockedVolumeReader::Reading::ReadSlab(
  int level, const isosurface::Progress& progress) const
{
  const isosurface::BlockBox slab =
    isosurface::PartitionBlocks(*this->Volume->FindLevel(level).Grid, this->Piece, this->Pieces);
  if (slab.IsEmpty())
  {
    return vtkSmartPointer<vtkDataSet>();
  }
  isosurface::QueryStatistics statistics;
  ISOSURFACE_ASSIGN_OR_RETURN(auto part,
    isosurface::ReadSlab(
      *this->Volume, slab, this->Step, this->Arrays, level, this->Threads, statistics, progress));
  vtkLogF(1,
    "%s: piece %d of %d: level %d: %llu blocks read, %llu from the cache, %llu bytes read, "
    "%.4f s",
    this->Volume->GetPath().c_str(), this->Piece, this->Pieces, level,
    static_cast<unsigned long long>(statistics.BlocksRead),
    static_cast<unsigned long long>(statistics.BlockCacheHits),
    static_cast<unsigned long long>(statistics.BytesRead), statistics.ReadSeconds);
  return part;
}

Status vtkBlockedVolumeReader::Reading::MakeSlab(vtkPartitionedDataSet* partitions) const
{
  vtkBlockedVolumeReader* reader = this->Reader;
  const std::optional<int> level = this->FindLevel();
  if (!level)
  {
    vtkWarningWithObjectMacro(reader, << reader->FileName
                                      << ": not even the coarsest level fits the memory limit of "
                                      << reader->MemoryLimit << " MiB: the output is empty.");
    return Status::Ok();
  }
  reader->Level = *level;
  reader->ShownText = DescribeLevel(this->Volume->GetHeader().Grid, *level);
  const bool isPrepared = reader->IsOutputPrepared(0) && reader->Prepared &&
    reader->Prepared->Work->GetStatus().IsOk() &&
    reader->Prepared->Fingerprint == this->ComputeFingerprint(*level);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto slab,
    isPrepared ? reader->Prepared->Slab
               : this->ReadSlab(*level, isosurface::MakeProgress(*reader)));
  if (slab)
  {
    partitions->SetNumberOfPartitions(1);
    partitions->SetPartition(0, slab);
  }
  return Status::Ok();
}

std::unique_ptr<vtkBlockedVolumeReader::PreparedOutput>
vtkBlockedVolumeReader::Reading::PrepareSlab() const
{
  const std::optional<int> level = this->FindLevel();
  if (!level)
  {
    return nullptr;
  }
  auto output = std::make_unique<PreparedOutput>();
  output->Fingerprint = this->ComputeFingerprint(*level);
  output->Work = std::make_unique<isosurface::BackgroundTask>(this->Volume->GetPath(),
    [reading = *this, level = *level, &slab = output->Slab](
      const isosurface::Progress& advance) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(slab, reading.ReadSlab(level, advance));
      return Status::Ok();
    });
  return output;
}

void vtkBlockedVolumeReader::PrepareOutput(vtkBlockedVolumeHandle* volume)
{
  isosurface::ControllerCommunicator ranks(this->Controller);
  const int threads = ranks.ChooseThreads(0);
  this->Prepared.reset();
  if (!this->Handle->IsOutputBox())
  {
    const auto prepare = [&]
    {
      const Reading reading(*this, *volume, this->GetOutputInformation(0), threads);
      this->Prepared = reading.PrepareSlab();
      return Status::Ok();
    };
    // The next execution tells what is wrong.
    static_cast<void>(isosurface::Attempt(volume->GetVolume()->GetPath(), prepare));
  }
}

bool vtkBlockedVolumeReader::IsOutputPrepared(double seconds)
{
  return !this->Prepared || this->Prepared->Work->Wait(seconds);
}

void vtkBlockedVolumeReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << " MiB\n";
  os << indent << "LocalStores: " << this->LocalStores << "\n";
  os << indent << "CacheSize: " << this->GetCacheSize() << " MiB\n";
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "Spacing: " << this->Spacing.size() << " numbers\n";
  os << indent << "Origin: " << this->Origin.size() << " numbers\n";
  os << indent << "LengthUnit: " << (this->LengthUnit ? this->LengthUnit : "") << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
  os << indent << "PointDataArraySelection:\n";
  this->PointDataArraySelection->PrintSelf(os, indent.GetNextIndent());
}
