// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkInPlaceVolumeReader.h"

#include "vtkBlockedVolumeHandle.h"
#include "vtkInformation.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSet.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "ImageSamples.h"

#include "Formats/Indexing/FetchBudget.h"
#include "Formats/Indexing/GrowingIndex.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Indexing/SourceSampler.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/PrintableText.h"
#include "Ground/Base/ReadingStop.h"
#include "Ranks/Query/Refinement.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/FinishedLayers.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkInPlaceVolumeReader);

namespace
{
using isosurface::GrowingIndex;
using isosurface::IndexState;
using isosurface::RefinementStage;
using isosurface::Result;
using isosurface::SourceIndex;
using isosurface::Status;
using isosurface::StatusCode;

constexpr const char* Automatic = "automatic";

std::string ToText(const char* text)
{
  return text ? text : "";
}

/// The reader's progress, which is also told in the log now and then: who waits at a terminal has no
/// status bar.
isosurface::Progress MakeLoggedProgress(
  vtkInPlaceVolumeReader& reader, const std::string& source, const isosurface::Communicator& ranks)
{
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds interval(10);
  return [advance = isosurface::MakeProgress(reader), source, isTold = ranks.GetRank() == 0,
           begin = Clock::now(), next = Clock::now() + interval, first = 2.0](double share) mutable
  {
    first = std::min(first, share);
    if (isTold && share > first && Clock::now() >= next)
    {
      next = Clock::now() + interval;
      const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      vtkLogF(INFO, "%s: is being indexed: %.0f %%, about %.0f s left", source.c_str(), 100 * share,
        seconds * (1 - share) / (share - first));
    }
    return advance(share);
  };
}
} // namespace

/// Finds, checks and writes the index of a reader's source.
struct vtkInPlaceVolumeReader::Steps
{
  explicit Steps(vtkInPlaceVolumeReader& reader)
    : Reader(reader)
  {
    this->Failure = isosurface::Attempt(ToText(reader.SourceName),
      [&]
      {
        if (reader.Found && reader.FindTime == reader.vtkAlgorithm::GetMTime())
        {
          this->Index = *reader.Found;
          return Status::Ok();
        }
        const std::string dataset =
          ToText(ToText(reader.RawSamples).empty() ? reader.Dataset : reader.RawSamples);
        isosurface::GridPlace place;
        ISOSURFACE_RETURN_IF_ERROR(reader.MakePlace(ToText(reader.SourceName), place));
        const double* const box = reader.FetchRegion;
        std::optional<std::array<double, 6>> bounds;
        if (box[0] <= box[1] && box[2] <= box[3] && box[4] <= box[5])
        {
          bounds = { box[0], box[1], box[2], box[3], box[4], box[5] };
        }
        ISOSURFACE_ASSIGN_OR_RETURN(this->Index,
          SourceIndex::FindPartOf(isosurface::GetLocalFileSystem(), ToText(reader.SourceName),
            dataset == Automatic ? "" : dataset, ToText(reader.Axes), ToText(reader.IndexFolder),
            place, bounds));
        reader.Found = std::make_unique<SourceIndex>(this->Index);
        reader.FindTime = reader.vtkAlgorithm::GetMTime();
        return Status::Ok();
      });
  }

  /// The state of the index on this rank.
  Result<IndexState> FindState() const
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Failure);
    if (ToText(this->Reader.SourceName).empty())
    {
      return Status(StatusCode::NotFound, "No file name is set.");
    }
    return isosurface::Attempt(this->Index.Path,
      [&] { return isosurface::FindIndexState(isosurface::GetLocalFileSystem(), this->Index); });
  }

  /// Collective. Whether there is no index, or one that is out of date, on any rank.
  Result<bool> IsIndexWanted(isosurface::Communicator& ranks) const;
  /// Collective. Makes the index, if it is wanted.
  Status Update(isosurface::Communicator& ranks);
  /// Collective. Begins to write the index beside this thread.
  Status Grow(isosurface::Communicator& ranks, isosurface::SourceSample sample);
  /// Collective. Waits for the index that is being written.
  Status Finish(isosurface::Communicator& ranks);
  /// Collective. Shows a sample of a time step and begins to write the index, if it is wanted.
  Status Begin(isosurface::Communicator& ranks, std::size_t step);
  /// Collective. Shows a sample of another time step.
  Status ChangeStep(isosurface::Communicator& ranks, std::size_t step);
  /// Tells the reader the times and the grid in the header of the source; no times if it cannot be read.
  void ReadHeader() const;

  /// Stores the window of DICOM beside its samples. (Others have none, and may take long to open.)
  void TellWindow(vtkInformation* outInfo) const;

  /// Collective. Has the reader read the volume in place, or the sample.
  Status Choose(isosurface::Communicator& ranks);

  bool IsGrowing() const
  {
    const GrowingIndex* const growing = this->Reader.Growing.get();
    // A sample has its grid for good. An index that is kept in memory is opened with another one.
    return growing && growing->GetIndex() == this->Index &&
      (this->Reader.Stage == RefinementStage::None ||
        growing->GetIndex().Place == this->Index.Place);
  }
  /// Of one name there is one budget, which counts what was fetched before, and whose limit may change.
  void SetBudget()
  {
    const std::uint64_t limit = static_cast<std::uint64_t>(this->Reader.FetchBudget) << 20;
    std::shared_ptr<isosurface::FetchBudget>& fetching = this->Reader.Fetching;
    if (!fetching || fetching->GetSource() != this->Index.Source)
    {
      fetching = std::make_shared<isosurface::FetchBudget>(this->Index.Source, limit);
    }
    fetching->SetLimit(limit);
    this->Index.Fetching = fetching;
  }
  std::uint64_t GetMemoryBytes() const
  {
    return static_cast<std::uint64_t>(this->Reader.IndexMemory) << 20;
  }
  void TellLeftOut(isosurface::Communicator& ranks, const std::string& leftOut) const
  {
    if (!leftOut.empty() && ranks.GetRank() == 0)
    {
      vtkLogF(INFO, "%s: %s", this->Index.Source.c_str(), leftOut.c_str());
    }
  }

  vtkInPlaceVolumeReader& Reader;
  SourceIndex Index;
  Status Failure; ///< of finding the index
};

Result<bool> vtkInPlaceVolumeReader::Steps::IsIndexWanted(isosurface::Communicator& ranks) const
{
  const auto state = this->FindState();
  std::vector<std::uint64_t> wanted = { state.IsOk() && *state != IndexState::Current ? 1u : 0u,
    state.IsOk() && *state == IndexState::Changed ? 1u : 0u };
  ISOSURFACE_RETURN_IF_ERROR(ranks.ReduceAgreed(state.GetStatus(), wanted));
  if (wanted[1] != 0 && ranks.GetRank() == 0)
  {
    vtkLogF(
      INFO, "%s: has changed since it was indexed; it is indexed anew", this->Index.Source.c_str());
  }
  return wanted[0] != 0;
}

Status vtkInPlaceVolumeReader::Steps::Update(isosurface::Communicator& ranks)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto wanted, this->IsIndexWanted(ranks));
  if (!wanted)
  {
    return Status::Ok();
  }
  if (ranks.GetSize() == 1 &&
    !isosurface::CanWriteIndex(isosurface::GetLocalFileSystem(), this->Index))
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Grow(ranks, {}));
    return this->Finish(ranks);
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto written,
    isosurface::WriteSourceIndex(ranks, isosurface::GetLocalFileSystem(), this->Index,
      this->GetMemoryBytes(), MakeLoggedProgress(this->Reader, this->Index.Source, ranks)));
  this->TellLeftOut(ranks, written);
  return Status::Ok();
}

Status vtkInPlaceVolumeReader::Steps::Finish(isosurface::Communicator& ranks)
{
  GrowingIndex& growing = *this->Reader.Growing;
  ISOSURFACE_RETURN_IF_ERROR(
    growing.Finish(ranks, MakeLoggedProgress(this->Reader, this->Index.Source, ranks)));
  this->TellLeftOut(ranks, growing.GetLeftOut());
  return Status::Ok();
}

void vtkInPlaceVolumeReader::Steps::ReadHeader() const
{
  isosurface::VolumeChoice choice;
  choice.Axes = this->Index.Axes;
  auto volume = this->Failure.IsOk()
    ? isosurface::OpenForeignVolume(isosurface::GetLocalFileSystem(), this->Index.Source, choice)
    : Result<isosurface::OpenedVolume>(this->Failure);
  this->Reader.SourceTimes = volume.IsOk() ? std::move(volume->Times) : std::vector<double>();
  if (volume.IsOk())
  {
    const isosurface::GridGeometry& grid = volume->Grid;
    this->Reader.TellGrid(
      volume->Lines ? volume->Lines->MakeFrame(grid, { { 0, 0, 0 }, grid.GetDimensions() }) : grid);
  }
}

Status vtkInPlaceVolumeReader::Steps::ChangeStep(isosurface::Communicator& ranks, std::size_t step)
{
  isosurface::SampleLimits limits;
  limits.Step = step;
  ISOSURFACE_ASSIGN_OR_RETURN(auto sample,
    isosurface::ReadSourceSample(ranks, isosurface::GetLocalFileSystem(), this->Index, limits,
      isosurface::MakeProgress(this->Reader)));
  this->Reader.Growing->SetSample(std::move(sample));
  return Status::Ok();
}

Status vtkInPlaceVolumeReader::Steps::Begin(isosurface::Communicator& ranks, std::size_t step)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto wanted, this->IsIndexWanted(ranks));
  if (!wanted)
  {
    return Status::Ok();
  }
  isosurface::SampleLimits limits;
  limits.Step = step;
  ISOSURFACE_ASSIGN_OR_RETURN(auto sample,
    isosurface::ReadSourceSample(ranks, isosurface::GetLocalFileSystem(), this->Index, limits,
      isosurface::MakeProgress(this->Reader)));
  // The index of a small file is there as soon as a sample.
  return sample.IsWhole ? this->Update(ranks) : this->Grow(ranks, std::move(sample));
}

void vtkInPlaceVolumeReader::Steps::TellWindow(vtkInformation* outInfo) const
{
  constexpr const char* name = "DICOM";
  vtkInPlaceVolumeReader& reader = this->Reader;
  auto* handle = BLOCKED_VOLUME()->GetHandle(outInfo);
  if (!handle || !handle->GetVolume() || !handle->GetVolume()->GetHeader().FindArray(name))
  {
    return;
  }
  if (reader.WindowSource != this->Index.Source)
  {
    reader.WindowSource = this->Index.Source;
    reader.Window = isosurface::FindWindow(isosurface::GetLocalFileSystem(), this->Index);
  }
  if (reader.Window)
  {
    isosurface::StoreWindow(vtkDataObject::GetData(outInfo), name, *reader.Window);
  }
}

Status vtkInPlaceVolumeReader::Steps::Choose(isosurface::Communicator& ranks)
{
  vtkInPlaceVolumeReader& reader = this->Reader;
  std::shared_ptr<isosurface::BlockedVolume> volume;
  vtkNew<vtkBlockedVolumeHandle> standIn;
  reader.Stage = RefinementStage::None;
  reader.IndexText = this->Index.Path + ": up to date";
  // Of a spent budget, AdvanceIndex tells.
  if (reader.Growing &&
    (!reader.Growing->Advance(ranks, 0) ||
      (reader.Fetching->IsSpent() && reader.Growing->GetSample().Volume)))
  {
    if (reader.Growing->HasLargerSample(ranks))
    {
      ISOSURFACE_RETURN_IF_ERROR(reader.Growing->EnlargeSample(ranks));
    }
    const isosurface::SourceSample& sample = reader.Growing->GetSample();
    volume = sample.Volume;
    standIn->SetSample(
      sample.Text, sample.Share == 1 && sample.Step == 0 ? this->Index.Path : "", sample.Share);
    standIn->SetFinished(reader.Growing->GetFinished());
    reader.Stage = RefinementStage::Working;
    reader.IndexText = this->Index.Path + ": is being written";
  }
  else if (reader.Growing)
  {
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(reader.Growing->GetStatus()));
    if (reader.Growing->IsInMemory()) // then this rank is alone
    {
      ISOSURFACE_ASSIGN_OR_RETURN(volume, reader.Growing->Open(this->Index.Place));
    }
  }
  standIn->SetVolume(volume);
  reader.SetStandIn(volume ? standIn.Get() : nullptr);
  if (!volume)
  {
    reader.Growing.reset();
    reader.SetFileName(nullptr); // a new file under the same path is opened again
    reader.SetFileName(this->Index.Path.c_str());
  }
  else if (standIn->GetSampleText().empty())
  {
    reader.IndexText = this->Index.Path + ": cannot be written; the index is kept in memory";
  }
  vtkLogF(1, "%s", reader.IndexText.c_str());
  return Status::Ok();
}

Status vtkInPlaceVolumeReader::Steps::Grow(
  isosurface::Communicator& ranks, isosurface::SourceSample sample)
{
  auto begun = isosurface::Attempt(this->Index.Source,
    [&]() -> Result<std::unique_ptr<GrowingIndex>>
    {
      return std::make_unique<GrowingIndex>(ranks, isosurface::GetLocalFileSystem(), this->Index,
        std::move(sample), this->GetMemoryBytes());
    });
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(begun.GetStatus()));
  this->Reader.Growing = std::move(*begun);
  this->Reader.TellSight();
  return Status::Ok();
}

vtkInPlaceVolumeReader::vtkInPlaceVolumeReader()
  : Datasets(vtkStringArray::New())
{
}

const char* vtkInPlaceVolumeReader::GetIndexText()
{
  // The message of a spent one tells it.
  const bool isTold = this->Fetching && !this->Fetching->IsSpent();
  const std::string fetched = isTold ? this->Fetching->Describe() : "";
  const bool isWaiting = this->Growing && this->Growing->IsWaiting();
  this->ToldText = this->IndexText +
    (isWaiting ? "; the budget is too small for all: what is looked at is read" : "") +
    (fetched.empty() ? "" : "; " + fetched);
  return this->ToldText.c_str();
}

vtkInPlaceVolumeReader::~vtkInPlaceVolumeReader()
{
  this->SetSourceName(nullptr);
  this->SetDataset(nullptr);
  this->SetRawSamples(nullptr);
  this->SetAxes(nullptr);
  this->SetIndexFolder(nullptr);
  this->Datasets->Delete();
}

int vtkInPlaceVolumeReader::CanReadFile(const char* fileName)
{
  // The dialog that asks cannot catch what a damaged file may throw.
  try
  {
    return isosurface::CanBeIndexed(isosurface::GetLocalFileSystem(), ToText(fileName)) ? 1 : 0;
  }
  catch (const std::exception&)
  {
    return 0;
  }
}

vtkStringArray* vtkInPlaceVolumeReader::GetDatasets()
{
  this->Datasets->Initialize();
  this->Datasets->InsertNextValue(Automatic);
  try
  {
    for (const std::string& name :
      isosurface::ListVolumes(isosurface::GetLocalFileSystem(), ToText(this->SourceName)))
    {
      this->Datasets->InsertNextValue(name);
    }
  }
  catch (const std::exception& exception)
  {
    vtkLogF(WARNING, "%s: its datasets cannot be listed: %s", ToText(this->SourceName).c_str(),
      exception.what());
  }
  if (this->Dataset && this->Datasets->LookupValue(this->Dataset) < 0)
  {
    this->Datasets->InsertNextValue(this->Dataset); // another name of one of them
  }
  return this->Datasets;
}

int vtkInPlaceVolumeReader::GetIsRaw()
{
  const std::string source = ToText(this->SourceName);
  const auto isRaw = isosurface::Attempt(source,
    [&]
    { return Result<bool>(isosurface::IsRawSource(isosurface::GetLocalFileSystem(), source)); });
  return !source.empty() && isRaw.IsOk() && *isRaw ? 1 : 0;
}

bool vtkInPlaceVolumeReader::IsPending()
{
  if (this->CheckTime == this->vtkAlgorithm::GetMTime())
  {
    return false;
  }
  const Steps steps(*this);
  const auto readHeader = [&]
  {
    if (this->TellTime != this->vtkAlgorithm::GetMTime())
    {
      this->TellTime = this->vtkAlgorithm::GetMTime();
      steps.ReadHeader();
    }
    return true;
  };
  if (steps.IsGrowing())
  {
    return readHeader();
  }
  const auto state = steps.FindState();
  const bool isCurrent = state.IsOk() && *state == IndexState::Current;
  this->IndexText = !state.IsOk() && steps.Index.Path.empty() ? state.GetStatus().GetMessage()
                                                              : steps.Index.Path +
      (isCurrent                          ? ": up to date"
          : !state.IsOk()                 ? ": " + state.GetStatus().GetMessage()
          : *state == IndexState::Changed ? ": out of date, Apply indexes anew"
                                          : ": Apply indexes the file");
  if (isCurrent)
  {
    this->Growing.reset(); // of another file
    this->Stage = RefinementStage::None;
    this->SetStandIn(nullptr);
    this->SetFileName(steps.Index.Path.c_str());
    this->CheckTime = this->vtkAlgorithm::GetMTime();
  }
  return !isCurrent && readHeader();
}

int vtkInPlaceVolumeReader::RequestInformation(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  if (!isosurface::IsAddress(ToText(this->SourceName)))
  {
    return this->Superclass::RequestInformation(request, input, output);
  }
  // An abortion stays known until data are asked for. One from before is none of what waits for a server now.
  const bool wasStopped = isosurface::IsAborted(*this);
  const isosurface::Progress look = [this, wasStopped](double)
  { return isosurface::MakeProgress(*this)(this->GetProgress()) || wasStopped; };
  const isosurface::ReadingStop stop(look);
  const int done = this->Superclass::RequestInformation(request, input, output);
  this->IsStopped = isosurface::ReadingStop::IsWanted();
  this->TellTime = this->IsStopped ? 0 : this->TellTime; // times are to be read again
  return done;
}

int vtkInPlaceVolumeReader::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  isosurface::ControllerCommunicator ranks(this->GetController());
  const isosurface::Progress look = [this](double)
  { return isosurface::MakeProgress(*this)(this->GetProgress()); };
  bool isPending = false;
  {
    const isosurface::ReadingStop stop(look);
    isPending = this->IsStopped || this->IsPending();
  }
  const std::size_t step = this->FindStep(output->GetInformationObject(0));
  const bool pending = ranks.Any(isPending || this->IsOtherSample(step));
  if (pending)
  {
    const isosurface::ReadingStop stop(look);
    const Status status = this->UpdateIndex(ranks, step);
    if (!status.IsOk())
    {
      vtkPartitionedDataSet::GetData(output, 0)->Initialize();
      // A consumer that takes blocks is not executed behind an error.
      auto* handle = BLOCKED_VOLUME()->GetHandle(output->GetInformationObject(0));
      if (handle && status.GetCode() != StatusCode::Aborted)
      {
        handle->EndTaking();
      }
      return isosurface::EndExecution(this, output, status);
    }
  }
  const int isRead = this->Superclass::RequestData(request, input, output);
  if (isRead != 0)
  {
    Steps(*this).TellWindow(output->GetInformationObject(0));
  }
  return isRead;
}

std::size_t vtkInPlaceVolumeReader::FindStep(vtkInformation* outInfo) const
{
  vtkInformationDoubleKey* const key = vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP();
  const bool isAsked = outInfo->Has(key);
  const double time = isAsked ? outInfo->Get(key) : 0;
  std::size_t found = 0;
  for (std::size_t step = 0; isAsked && step < this->SourceTimes.size(); ++step)
  {
    found = this->SourceTimes[step] <= time ? step : found;
  }
  return found;
}

bool vtkInPlaceVolumeReader::IsOtherSample(std::size_t step) const
{
  return this->Growing && this->Stage != RefinementStage::None &&
    this->Growing->GetSample().Volume && this->Growing->GetSample().Step != step;
}

isosurface::Status vtkInPlaceVolumeReader::UpdateIndex(
  isosurface::Communicator& ranks, std::size_t step)
{
  Steps steps(*this);
  if (std::exchange(this->IsStopped, false))
  {
    steps.Failure = Status(StatusCode::Aborted, ToText(this->SourceName) + ": reading was stopped");
  }
  std::vector<std::uint64_t> all = { this->CoarseAllowed ? 0u : 1u, steps.IsGrowing() ? 0u : 1u,
    step };
  ISOSURFACE_RETURN_IF_ERROR(ranks.ReduceAgreed(steps.Failure, all));
  steps.SetBudget();
  this->Indexed = nullptr;
  step = static_cast<std::size_t>(all[2]);
  const bool isCoarse = all[0] == 0;
  const bool isGrowing = all[1] == 0;
  // One in memory stays when it has been taken.
  const bool isOld =
    isGrowing && this->Stage == RefinementStage::None && !this->Growing->IsCurrent();
  const bool isSpent =
    isGrowing && isCoarse && this->Growing->Advance(ranks, 0) && this->Fetching->IsSpent();
  Status status;
  if (!isGrowing || this->Stage == RefinementStage::Failed || isOld || isSpent)
  {
    this->Growing.reset();
    status = isCoarse ? steps.Begin(ranks, step) : steps.Update(ranks);
  }
  else if (!isCoarse || this->Growing->Advance(ranks, 0))
  {
    status = steps.Finish(ranks);
  }
  else if (this->IsOtherSample(step))
  {
    status = steps.ChangeStep(ranks, step);
  }
  status = status.IsOk() ? steps.Choose(ranks) : status;
  if (!status.IsOk())
  {
    this->Growing.reset();
    return status;
  }
  this->CheckTime = this->vtkAlgorithm::GetMTime();
  return Status::Ok();
}

void vtkInPlaceVolumeReader::AllowCoarse(vtkTypeBool allowed)
{
  this->CoarseAllowed = allowed != 0;
}

void vtkInPlaceVolumeReader::AdvanceIndex(int milliseconds)
{
  isosurface::ControllerCommunicator ranks(this->GetController());
  const bool isWorking = ranks.All(this->Stage == RefinementStage::Working);
  if (!isWorking)
  {
    return;
  }
  const double seconds = std::max(0, milliseconds) / 1000.0;
  const bool hasEnded = this->Growing->Advance(ranks, seconds);
  this->Fetching->Gather(ranks);
  if (hasEnded)
  {
    const Status status = ranks.Agree(this->Growing->GetStatus());
    const bool isReady = status.IsOk() && this->PrepareVolume(ranks, seconds);
    this->Stage = !status.IsOk() ? RefinementStage::Failed
      : isReady                  ? RefinementStage::Ready
                                 : RefinementStage::Working;
    if (status.GetCode() == StatusCode::Aborted)
    {
      this->IndexText = this->Growing->GetIndex().Path + ": writing it was stopped";
    }
    else if (!status.IsOk() && this->Fetching->IsSpent())
    {
      this->IndexText = status.GetMessage();
      vtkWarningMacro(<< isosurface::MakePrintable(status.GetMessage()));
    }
    else if (!status.IsOk())
    {
      this->IndexText = status.GetMessage();
      vtkErrorMacro(<< isosurface::MakePrintable(status.GetMessage()));
    }
  }
  else if (this->Growing->HasLargerSample(ranks))
  {
    this->Stage = RefinementStage::Ready;
  }
}

void vtkInPlaceVolumeReader::LookAlong(const double sight[8])
{
  this->Looked = std::make_unique<isosurface::Sight>();
  std::copy_n(sight, 3, this->Looked->Eye.begin());
  std::copy_n(sight + 3, 3, this->Looked->Direction.begin());
  this->Looked->Radius = sight[6];
  this->Looked->Widening = sight[7];
  this->TellSight();
}

void vtkInPlaceVolumeReader::TellSight()
{
  if (this->Looked && this->Growing && this->Growing->GetFinished())
  {
    this->Growing->GetFinished()->LookAlong(*this->Looked);
  }
}

double* vtkInPlaceVolumeReader::GetRefinement()
{
  isosurface::Refinement refinement;
  refinement.Stage = this->Stage;
  if (this->Growing)
  {
    refinement.Share = this->Growing->IsWaiting() ? -1 : this->Growing->GetProgress();
    refinement.Bytes = this->Fetching ? static_cast<double>(this->Fetching->CountFetched()) : 0;
    refinement.FreeBytes = this->Fetching ? static_cast<double>(this->Fetching->GetLimit()) : 0;
    refinement.Seconds = this->Growing->EstimateSeconds();
  }
  this->Refinement = refinement.ToValues();
  return this->Refinement.data();
}

bool vtkInPlaceVolumeReader::PrepareVolume(isosurface::Communicator& ranks, double seconds)
{
  if (!this->Indexed)
  {
    const auto opened = isosurface::Attempt(this->Growing->GetIndex().Path,
      [this] { return this->Growing->Open(this->Growing->GetIndex().Place); });
    const bool isOpen = ranks.All(opened.IsOk());
    if (!isOpen)
    {
      return true; // whoever takes it tells what is wrong
    }
    this->Indexed = vtkSmartPointer<vtkBlockedVolumeHandle>::New();
    this->Indexed->SetVolume(*opened);
    this->PrepareOutput(this->Indexed);
  }
  return ranks.All(this->IsOutputPrepared(seconds));
}

void vtkInPlaceVolumeReader::StopIndex()
{
  if (this->Growing)
  {
    this->Growing->Stop();
  }
}

void vtkInPlaceVolumeReader::TakeIndex()
{
  if (this->Growing)
  {
    this->Modified();
  }
}

void vtkInPlaceVolumeReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SourceName: " << ToText(this->SourceName) << "\n";
  os << indent << "Dataset: " << ToText(this->Dataset) << "\n";
  os << indent << "RawSamples: " << ToText(this->RawSamples) << "\n";
  os << indent << "Axes: " << ToText(this->Axes) << "\n";
  os << indent << "IndexFolder: " << ToText(this->IndexFolder) << "\n";
  os << indent << "IndexMemory: " << this->IndexMemory << " MiB\n";
  os << indent << "FetchRegion: " << this->FetchRegion[0] << " " << this->FetchRegion[1] << " "
     << this->FetchRegion[2] << " " << this->FetchRegion[3] << " " << this->FetchRegion[4] << " "
     << this->FetchRegion[5] << "\n";
  os << indent << "FetchBudget: " << this->FetchBudget << " MiB\n";
  os << indent << "CoarseAllowed: " << this->CoarseAllowed << "\n";
  os << indent << "IndexText: " << this->IndexText << "\n";
}
