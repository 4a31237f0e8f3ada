// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeCommands.h"

#include "ProgressDisplay.h"
#include "Sandbox.h"

#include "Ground/Base/ParallelFor.h"
#include "Storage/Verification/VolumeRepair.h"

#include <cstdio>
#include <string>

namespace isosurface
{

Status RunRepairCommand(const BlockVolumeOptions& options)
{
  const int threads =
    options.Settings.Threads > 0 ? options.Settings.Threads : ChooseThreadCount(1);
  ProgressDisplay display(options.Input, 0, !options.IsQuiet);
  const Progress progress = display.GetProgress();
  const auto done =
    RepairBlockedVolume(options.Input, GetLocalFileSystem(), threads, RenewTimeWith(progress));
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
        : (FormatBytes(static_cast<double>(done->Bytes)) + " restored").c_str(),
      display.GetSeconds());
  }
  return Status::Ok();
}

} // namespace isosurface
