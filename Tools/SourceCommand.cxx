// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeCommands.h"

#include "ProgressDisplay.h"
#include "Sandbox.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/ParallelFor.h"
#include "Storage/Writing/SourceRelocation.h"

#include <cstdio>

namespace isosurface
{

Status RunSourceCommand(const BlockVolumeOptions& options)
{
  const int threads =
    options.Settings.Threads > 0 ? options.Settings.Threads : ChooseThreadCount(1);
  ProgressDisplay display(options.Input, 0, !options.IsQuiet);
  const Progress progress = display.GetProgress();
  ISOSURFACE_RETURN_IF_ERROR(RelocateSource(GetLocalFileSystem(), OpenForeignVolume, options.Input,
    options.Source, threads, RenewTimeWith(progress)));
  display.Clear();
  if (!options.IsQuiet)
  {
    std::printf("%s: has its samples in %s\n", options.Input.c_str(), options.Source.c_str());
  }
  return Status::Ok();
}

} // namespace isosurface
