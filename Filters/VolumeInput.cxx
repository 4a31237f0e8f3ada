// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeInput.h"

#include "PassingFilters.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"

#include "vtkAlgorithm.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSet.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/WithinMemory.h"
#include "Ground/Volume/ChosenScalars.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>

namespace isosurface
{
namespace
{

// Whether a filter between the reader and this information's port passes chosen arrays alone.
bool IsBehindChoice(vtkInformation* info)
{
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(info);
  const PassedArrays passed = FindPassedArrays(executive->GetAlgorithm());
  return passed == PassedArrays::Chosen ||
    (passed == PassedArrays::All && executive->GetNumberOfInputConnections(0) > 0 &&
      IsBehindChoice(executive->GetInputInformation(0, 0)));
}

} // namespace

VolumeInput::VolumeInput(vtkInformation* inInfo)
  : Info(inInfo)
  , Handle(vtkBlockedVolumeReader::BLOCKED_VOLUME()->GetHandle(inInfo))
{
}

Status VolumeInput::GetStatus() const
{
  return this->Handle ? this->Handle->GetStatus() : Status::Ok();
}

std::vector<CommonValue> VolumeInput::MakeCommonValues() const
{
  // Images have the time steps of their source.
  const auto key = vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP();
  Fingerprint time;
  time.AddNumber(this->Info->Has(key) ? 1 : 0);
  time.AddReal(this->Info->Has(key) ? this->Info->Get(key) : 0);
  return {
    { this->Handle ? 1U : 0U,
      "some ranks have a blocked volume at the input of the filter, and some have images" },
    this->Handle ? this->Handle->MakeCommonValue() : CommonValue{ 0, "" },
    { this->Handle ? this->GetTimeStep() : time.Get(), "the ranks ask for different time steps" },
    { this->GetVolume() && this->GetVolume()->HasLocalStores() ? 1U : 0U,
      "LocalStores of the reader is not the same on all ranks" },
  };
}

std::shared_ptr<BlockedVolume> VolumeInput::GetVolume() const
{
  return this->Handle ? this->Handle->GetVolume() : nullptr;
}

std::size_t VolumeInput::GetTimeStep() const
{
  return this->Handle->FindTimeStep(this->Info);
}

bool VolumeInput::IsLeftOut(const std::string& name) const
{
  if (!IsBehindChoice(this->Info))
  {
    return false;
  }
  const auto images =
    vtkCompositeDataSet::GetDataSets<vtkDataSet>(vtkDataObject::GetData(this->Info));
  return std::any_of(images.begin(), images.end(),
    [&](vtkDataSet* image) { return !image->GetPointData()->HasArray(name.c_str()); });
}

Result<std::size_t> VolumeInput::FindArray(const std::string& name, const char* purpose) const
{
  const BlockedVolume& volume = *this->GetVolume();
  const BlockedVolumeHeader& header = volume.GetHeader();
  const auto array = name.empty() ? std::optional<std::size_t>(0) : header.FindArray(name);
  if (!array)
  {
    return Status(
      StatusCode::NotFound, volume.GetPath() + ": has no array \"" + name + "\" to " + purpose);
  }
  if (this->IsLeftOut(header.Arrays[*array].Name))
  {
    return Status(StatusCode::NotFound,
      "the input has no point array \"" + header.Arrays[*array].Name + "\" to " + purpose);
  }
  return *array;
}

Result<std::size_t> VolumeInput::FindVariable(const std::string& name, int component) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto array, this->FindArray(name, "contour"));
  const BlockedVolume& volume = *this->GetVolume();
  const auto variable = volume.GetVariables().FindChoice(array, component);
  if (!variable)
  {
    const ArrayDescription& description = volume.GetHeader().Arrays[array];
    return MakeComponentError(description.Name, description.Components, component);
  }
  return *variable;
}

void AskVolume(vtkAlgorithm& filter, vtkInformation* inInfo, int piece, int pieces, int ghostLevels)
{
  using Keys = vtkStreamingDemandDrivenPipeline;
  inInfo->Set(Keys::UPDATE_PIECE_NUMBER(), piece);
  inInfo->Set(Keys::UPDATE_NUMBER_OF_PIECES(), pieces);
  inInfo->Set(Keys::UPDATE_NUMBER_OF_GHOST_LEVELS(), ghostLevels);
  if (const VolumeInput input(inInfo); input)
  {
    input.GetHandle().BeginTaking(&filter);
  }
}

void AskVolume(
  vtkAlgorithm& filter, vtkInformation* inInfo, vtkInformation* outInfo, int ghostLevels)
{
  using Keys = vtkStreamingDemandDrivenPipeline;
  AskVolume(filter, inInfo, outInfo->Get(Keys::UPDATE_PIECE_NUMBER()),
    outInfo->Get(Keys::UPDATE_NUMBER_OF_PIECES()), ghostLevels);
}

void ReleaseVolume(vtkAlgorithm& filter, vtkInformation* inInfo)
{
  if (const VolumeInput input(inInfo); input)
  {
    input.GetHandle().EndTaking(&filter);
  }
}

Status AgreeOnVolume(
  vtkAlgorithm& filter, Communicator& ranks, const VolumeInput& input, std::uint64_t properties)
{
  if (input)
  {
    input.GetHandle().EndTaking(&filter);
  }
  Status opened = input.GetStatus();
  if (!input)
  {
    opened = Status(StatusCode::InvalidArgument,
      "the input is no blocked volume or volume in place. For data in memory use ParaView's "
      "Slice, Extract Subset or Resample With Dataset");
  }
  else if (input.GetHandle().IsUntried())
  {
    // Its reader could not make it, and has told why.
    opened = Status(StatusCode::Aborted, "there is no volume to read");
  }
  std::vector<CommonValue> common = input.MakeCommonValues();
  common.push_back({ properties, "the properties of the filter are not the same on all ranks" });
  return ranks.Agree(opened, common);
}

Status ReadVolume(vtkAlgorithm& filter, Communicator& ranks, const VolumeInput& input,
  const std::function<Status()>& read)
{
  BlockedVolume& volume = *input.GetVolume();
  Status status = RunWithinMemory(volume.GetPath(), BlockedVolume::NoMemoryReason,
    [&]
    {
      const Status unchanged = volume.CheckSource(input.GetTimeStep());
      return unchanged.IsOk() ? read() : unchanged;
    });
  ISOSURFACE_ASSIGN_OR_RETURN(const auto news, volume.ShareStoreFaults(ranks));
  status = AgreeOnEnd(filter, ranks, status);
  ReportWarning(&filter, ranks, status, news.Warning);
  return status;
}

} // namespace isosurface
