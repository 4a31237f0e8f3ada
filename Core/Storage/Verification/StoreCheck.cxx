// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Verification/StoreCheck.h"

#include "Ground/Base/ParallelFor.h"
#include "Storage/Verification/MergedStore.h"
#include "Storage/Verification/StoreVerification.h"

#include <algorithm>
#include <cstddef>

namespace isosurface
{

std::vector<Status> CheckStore(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::string& folder, int threads)
{
  const ArrayVariables variables = header.GetVariables();
  const BlockGrid grid = header.GetBlockGrid();
  StoreVerification check(files, variables, grid, step.Stores[store], folder,
    step.Source ? SamplePlace::Source : SamplePlace::Store, nullptr);
  check.Open();
  ParallelFor(static_cast<std::size_t>(check.GetNumberOfRuns()), threads,
    [&](std::size_t run, int) { check.CheckRun(run); });
  std::vector<std::uint8_t> unused;
  check.Finish(unused);
  return check.TakeFaults();
}

Status CheckReplicas(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::vector<std::string>& folders,
  int threads)
{
  MergedStore merged(files, header, step, store, folders);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto lost, merged.FindLostBlocks());
  if (!lost.empty())
  {
    constexpr std::size_t listed = 100;
    std::string blocks;
    for (std::size_t index = 0; index < std::min(listed, lost.size()); ++index)
    {
      blocks += (index == 0 ? "" : ", ") + std::to_string(lost[index]);
    }
    if (lost.size() > listed)
    {
      blocks += " and " + std::to_string(lost.size() - listed) + " more";
    }
    return Status(StatusCode::Corrupt,
      folders.front() + ": no replica has " + (lost.size() == 1 ? "block " : "the blocks ") +
        blocks);
  }
  const std::vector<Status> faults =
    CheckStore(merged, header, step, store, folders.front(), threads);
  return faults.empty() ? Status::Ok() : faults.front();
}

} // namespace isosurface
