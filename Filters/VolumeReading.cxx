// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeReading.h"

#include "VolumeInput.h"
#include "vtkBlockedVolumeHandle.h"

#include "vtkAlgorithm.h"
#include "vtkInformation.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ErrorReport.h"
#include "Ground/Base/WithinMemory.h"
#include "Storage/Store/BlockedVolume.h"

#include <vector>

namespace isosurface
{

void AskVolume(vtkAlgorithm& filter, vtkInformation* inInfo, vtkInformation* outInfo)
{
  using Keys = vtkStreamingDemandDrivenPipeline;
  inInfo->Set(Keys::UPDATE_PIECE_NUMBER(), outInfo->Get(Keys::UPDATE_PIECE_NUMBER()));
  inInfo->Set(Keys::UPDATE_NUMBER_OF_PIECES(), outInfo->Get(Keys::UPDATE_NUMBER_OF_PIECES()));
  inInfo->Set(Keys::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  if (const VolumeInput input(inInfo); input)
  {
    input.GetHandle().BeginTaking(&filter);
  }
}

Status ReadVolume(vtkAlgorithm& filter, Communicator& ranks, const VolumeInput& input,
  std::uint64_t properties, const std::function<Status(int threads)>& read)
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
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(opened, common));
  const int threads = ranks.ChooseThreads(0);
  BlockedVolume& volume = *input.GetVolume();
  Status status = RunWithinMemory(volume.GetPath(), BlockedVolume::NoMemoryReason,
    [&]
    {
      const Status unchanged = volume.CheckSource(input.GetTimeStep());
      return unchanged.IsOk() ? read(threads) : unchanged;
    });
  if (IsAborted(filter))
  {
    status = Status(StatusCode::Aborted, "reading was aborted");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto news, volume.ShareStoreFaults(ranks));
  status = ranks.Agree(status);
  ReportWarning(&filter, ranks, status, news.Warning);
  return status;
}

} // namespace isosurface
