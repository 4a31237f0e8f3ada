// SPDX-License-Identifier: BSD-3-Clause
// The commands that list, check, repair and relocate volumes.
#include "BlockVolumeCommands.h"
#include "ProgressDisplay.h"
#include "Sandbox.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/PrintableText.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Verification/VolumeRepair.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Storage/Writing/SourceRelocation.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string>

namespace isosurface
{
namespace
{

int CountThreads(const BlockVolumeOptions& options)
{
  return options.Settings.Threads > 0 ? options.Settings.Threads : ChooseThreadCount(1);
}

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

Status RunListCommand(const BlockVolumeOptions& options)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto list, ListForeignVolumes(GetLocalFileSystem(), options.Input));
  for (VolumeListing& entry : list)
  {
    for (std::string* text : { &entry.Name, &entry.Shape, &entry.Type, &entry.Storage })
    {
      *text = MakePrintable(*text);
    }
  }
  std::size_t widths[3] = {};
  for (const VolumeListing& entry : list)
  {
    widths[0] = std::max(widths[0], entry.Name.size());
    widths[1] = std::max(widths[1], entry.Shape.size());
    widths[2] = std::max(widths[2], entry.Type.size());
  }
  for (const VolumeListing& entry : list)
  {
    std::printf("%-*s  %-*s  %-*s  %s\n", static_cast<int>(widths[0]), entry.Name.c_str(),
      static_cast<int>(widths[1]), entry.Shape.c_str(), static_cast<int>(widths[2]),
      entry.Type.c_str(), entry.Storage.c_str());
  }
  return Status::Ok();
}

Status RunSourceCommand(const BlockVolumeOptions& options)
{
  ProgressDisplay display(options.Input, 0, !options.IsQuiet);
  const Progress progress = display.GetProgress();
  ISOSURFACE_RETURN_IF_ERROR(RelocateSource(GetLocalFileSystem(), OpenForeignVolume, options.Input,
    options.Source, CountThreads(options), RenewTimeWith(progress)));
  display.Clear();
  if (!options.IsQuiet)
  {
    std::printf("%s: has its samples in %s\n", options.Input.c_str(), options.Source.c_str());
  }
  return Status::Ok();
}

Status RunRepairCommand(const BlockVolumeOptions& options)
{
  ProgressDisplay display(options.Input, 0, !options.IsQuiet);
  const Progress progress = display.GetProgress();
  const auto done = RepairBlockedVolume(
    options.Input, GetLocalFileSystem(), CountThreads(options), RenewTimeWith(progress));
  display.Clear();
  ISOSURFACE_RETURN_IF_ERROR(done.GetStatus());
  if (!options.IsQuiet)
  {
    for (const std::string& folder : done->Restored)
    {
      std::printf("%s: restored\n", folder.c_str());
    }
  }
  if (!done->Refused.empty())
  {
    for (std::size_t index = 0; index + 1 < done->Refused.size(); ++index)
    {
      std::fprintf(
        stderr, "blockvolume: cannot be restored: %s\n", done->Refused[index].GetMessage().c_str());
    }
    return Status(StatusCode::Corrupt, "cannot be restored: " + done->Refused.back().GetMessage());
  }
  if (!options.IsQuiet)
  {
    std::printf("%s: %s, %.1f s\n", options.Input.c_str(),
      done->Restored.empty()
        ? "nothing to restore"
        : (DescribeBytes(static_cast<double>(done->Bytes)) + " restored").c_str(),
      display.GetSeconds());
  }
  return Status::Ok();
}

Status RunVerifyCommand(const BlockVolumeOptions& options)
{
  ProgressDisplay display(options.Input, CountBytes(options.Input), !options.IsQuiet);
  const Progress progress = display.GetProgress();
  const auto found = VerifyBlockedVolume(options.Input, GetLocalFileSystem(), CountThreads(options),
    RenewTimeWith(progress), OpenForeignVolume);
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
      static_cast<unsigned long long>(found->Blocks), DescribeBytes(bytes).c_str(), seconds,
      bytes / 1e6 / std::max(seconds, 1e-9));
  }
  return Status::Ok();
}

} // namespace isosurface
