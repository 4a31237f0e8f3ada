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
#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Opener/VolumeFormat.h"
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

/// Whether the reader offers to open files of a format.
bool IsIndexed(const isosurface::VolumeFormat* format)
{
  return format && (format->Name == "Zarr" || format->Name == "HDF5");
}

/// The names of the volumes in a file; none if it cannot be read.
std::vector<std::string> FindNames(const std::string& fileName)
{
  std::vector<std::string> names;
  isosurface::FileSystem& files = isosurface::GetLocalFileSystem();
  const SourceIndex index = SourceIndex::Find(files, fileName, "", "", "");
  const auto listed =
    isosurface::ListForeignVolumes(files, isosurface::VolumeName::Parse(files, index.Source).Path);
  for (std::size_t entry = 0; listed.IsOk() && entry < listed->size(); ++entry)
  {
    names.push_back((*listed)[entry].Name);
  }
  return names;
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
        this->Index = SourceIndex::Find(isosurface::GetLocalFileSystem(), ToText(reader.SourceName),
          ToText(reader.Dataset) == Automatic ? "" : ToText(reader.Dataset), ToText(reader.Axes),
          ToText(reader.IndexFolder));
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
    isosurface::FileSystem& files = isosurface::GetLocalFileSystem();
    const SourceIndex index = SourceIndex::Find(files, ToText(fileName), "", "", "");
    return IsIndexed(isosurface::FindVolumeFormat(
             files, isosurface::VolumeName::Parse(files, index.Source)))
      ? 1
      : 0;
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
    for (const std::string& name : FindNames(ToText(this->SourceName)))
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
  os << indent << "Axes: " << ToText(this->Axes) << "\n";
  os << indent << "IndexFolder: " << ToText(this->IndexFolder) << "\n";
  os << indent << "IndexMemory: " << this->IndexMemory << " MiB\n";
  os << indent << "IndexText: " << this->IndexText << "\n";
}
