// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeCommands.h"

#include "ProgressDisplay.h"
#include "Sandbox.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/PrintableText.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Verification/VolumeVerification.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace isosurface
{
namespace
{

/// The bytes of all records, to show bytes a second; 0 if the header cannot be read.
double CountBytes(const std::string& path)
{
  const auto volume = BlockedVolume::Open(path);
  double bytes = 0;
  if (volume.IsOk())
  {
    for (const TimeStepDescription& step : (*volume)->GetHeader().TimeSteps)
    {
      for (const StoreDescription& store : step.Stores)
      {
        bytes += static_cast<double>(store.Bytes) * (*volume)->GetHeader().NumberOfReplicas;
      }
    }
  }
  return bytes;
}

} // namespace

Status RunVerifyCommand(const BlockVolumeOptions& options)
{
  const int threads =
    options.Settings.Threads > 0 ? options.Settings.Threads : ChooseThreadCount(1);
  ProgressDisplay display(options.Input, CountBytes(options.Input), !options.IsQuiet);
  const Progress progress = display.GetProgress();
  const auto found = VerifyBlockedVolume(
    options.Input, GetLocalFileSystem(), threads, RenewTimeWith(progress), OpenForeignVolume);
  const double seconds = display.GetSeconds();
  display.Clear();
  ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
  for (const Status& fault : found->Faults)
  {
    std::fprintf(stderr, "blockvolume: %s\n", MakePrintable(fault.GetMessage()).c_str());
  }
  for (const std::string& repair : found->Repairs)
  {
    std::fprintf(stderr, "blockvolume: %s\n", MakePrintable(repair).c_str());
  }
  if (found->FaultCount > 0)
  {
    return Status(
      StatusCode::Corrupt, options.Input + ": " + std::to_string(found->FaultCount) + " faults");
  }
  if (!options.IsQuiet)
  {
    const auto bytes = static_cast<double>(found->Bytes);
    std::printf("%s: sound: %llu files, %llu blocks, %s, %.1f s, %.0f MB/s\n",
      options.Input.c_str(), static_cast<unsigned long long>(found->Files),
      static_cast<unsigned long long>(found->Blocks), FormatBytes(bytes).c_str(), seconds,
      bytes / 1e6 / std::max(seconds, 1e-9));
  }
  return Status::Ok();
}

} // namespace isosurface
