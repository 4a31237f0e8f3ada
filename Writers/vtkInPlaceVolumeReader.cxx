// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkInPlaceVolumeReader.h"

#include "vtkBlockedVolumeHandle.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSet.h"
#include "vtkStringArray.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"

#include "Formats/Indexing/SourceIndex.h"
#include "Ground/Base/FileSystem.h"

#include <exception>
#include <string>
#include <vector>

vtkStandardNewMacro(vtkInPlaceVolumeReader);

namespace
{
using isosurface::IndexState;
using isosurface::Result;
using isosurface::SourceIndex;
using isosurface::Status;
using isosurface::StatusCode;

constexpr const char* Automatic = "automatic";

std::string ToText(const char* text)
{
  return text ? text : "";
}
} // namespace

/// Finds, checks and writes the index of a reader's source.
struct vtkInPlaceVolumeReader::Indexing
{
  explicit Indexing(vtkInPlaceVolumeReader& reader)
    : Reader(reader)
  {
    this->Failure = isosurface::Attempt(ToText(reader.SourceName),
      [&]
      {
        const std::string dataset =
          ToText(ToText(reader.RawSamples).empty() ? reader.Dataset : reader.RawSamples);
        this->Index = SourceIndex::Find(isosurface::GetLocalFileSystem(), ToText(reader.SourceName),
          dataset == Automatic ? "" : dataset, ToText(reader.Axes), ToText(reader.IndexFolder));
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

  /// Collective. Makes the index if one rank finds it missing or out of date.
  Status Update(isosurface::Communicator& ranks);

  vtkInPlaceVolumeReader& Reader;
  SourceIndex Index;
  Status Failure; ///< of finding the index
};

Status vtkInPlaceVolumeReader::Indexing::Update(isosurface::Communicator& ranks)
{
  const auto state = this->FindState();
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(state.GetStatus()));
  std::vector<std::uint64_t> wanted = { *state != IndexState::Current ? 1u : 0u,
    *state == IndexState::Changed ? 1u : 0u };
  ranks.ReduceMaximum(wanted);
  if (wanted[0] == 0)
  {
    return Status::Ok();
  }
  if (wanted[1] != 0 && ranks.GetRank() == 0)
  {
    vtkLogF(
      INFO, "%s: has changed since it was indexed; it is indexed anew", this->Index.Source.c_str());
  }
  vtkInPlaceVolumeReader& reader = this->Reader;
  constexpr std::uint64_t mebibyte = 1024 * 1024;
  const auto written =
    isosurface::WriteSourceIndex(ranks, isosurface::GetLocalFileSystem(), this->Index,
      static_cast<std::uint64_t>(reader.IndexMemory) * mebibyte, isosurface::MakeProgress(reader));
  ISOSURFACE_RETURN_IF_ERROR(written.GetStatus());
  if (!written->empty() && ranks.GetRank() == 0)
  {
    vtkLogF(INFO, "%s: %s", this->Index.Source.c_str(), written->c_str());
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
vtkInPlaceVolumeReader::vtkInPlaceVolumeReader()
  : SourceName(nullptr)
  , Dataset(nullptr)
  , RawSamples(nullptr)
  , Axes(nullptr)
  , IndexFolder(nullptr)
  , IndexMemory(1024)
  , Datasets(vtkStringArray::New())
  , CheckTime(0)
{
}

//------------------------------------------------------------------------------
vtkInPlaceVolumeReader::~vtkInPlaceVolumeReader()
{
  this->SetSourceName(nullptr);
  this->SetDataset(nullptr);
  this->SetRawSamples(nullptr);
  this->SetAxes(nullptr);
  this->SetIndexFolder(nullptr);
  this->Datasets->Delete();
}

//------------------------------------------------------------------------------
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

//------------------------------------------------------------------------------
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
  return this->Datasets;
}

//------------------------------------------------------------------------------
int vtkInPlaceVolumeReader::GetIsRaw()
{
  const std::string source = ToText(this->SourceName);
  const auto isRaw = isosurface::Attempt(source,
    [&]
    { return Result<bool>(isosurface::IsRawSource(isosurface::GetLocalFileSystem(), source)); });
  return !source.empty() && isRaw.IsOk() && *isRaw ? 1 : 0;
}

//------------------------------------------------------------------------------
bool vtkInPlaceVolumeReader::IsPending()
{
  if (this->CheckTime == this->vtkAlgorithm::GetMTime())
  {
    return false;
  }
  const Indexing indexing(*this);
  const auto state = indexing.FindState();
  const bool isCurrent = state.IsOk() && *state == IndexState::Current;
  this->IndexText = indexing.Index.Path +
    (isCurrent                          ? ": up to date"
        : !state.IsOk()                 ? ": " + state.GetStatus().GetMessage()
        : *state == IndexState::Changed ? ": out of date, Apply indexes anew"
                                        : ": Apply indexes the file in place");
  if (isCurrent)
  {
    this->SetFileName(indexing.Index.Path.c_str());
    this->CheckTime = this->vtkAlgorithm::GetMTime();
  }
  return !isCurrent;
}

//------------------------------------------------------------------------------
int vtkInPlaceVolumeReader::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  isosurface::ControllerCommunicator ranks(this->GetController());
  std::vector<std::uint64_t> pending = { this->IsPending() ? 1u : 0u };
  ranks.ReduceMaximum(pending);
  if (pending[0] != 0)
  {
    Indexing indexing(*this);
    const Status status = indexing.Update(ranks);
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
    this->SetFileName(nullptr); // a new file under the same path is opened again
    this->SetFileName(indexing.Index.Path.c_str());
    this->IndexText = indexing.Index.Path + ": up to date";
    this->CheckTime = this->vtkAlgorithm::GetMTime();
  }
  return this->Superclass::RequestData(request, input, output);
}

//------------------------------------------------------------------------------
void vtkInPlaceVolumeReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SourceName: " << ToText(this->SourceName) << "\n";
  os << indent << "Dataset: " << ToText(this->Dataset) << "\n";
  os << indent << "RawSamples: " << ToText(this->RawSamples) << "\n";
  os << indent << "Axes: " << ToText(this->Axes) << "\n";
  os << indent << "IndexFolder: " << ToText(this->IndexFolder) << "\n";
  os << indent << "IndexMemory: " << this->IndexMemory << " MiB\n";
  os << indent << "IndexText: " << this->IndexText << "\n";
}
