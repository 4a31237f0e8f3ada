// SPDX-License-Identifier: BSD-3-Clause
#include "WriteCommand.h"

#include "InputVolume.h"
#include "ProgressDisplay.h"

#include "Writing/BlockedVolumeWriter.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

namespace isosurface
{

namespace
{

/// Writes one time step of the input.
Status WriteStep(const BlockVolumeOptions& options, InputVolume volume, Communicator& ranks)
{
  double sampleBytes = 0;
  for (const ArrayDescription& array : volume.Arrays)
  {
    sampleBytes += static_cast<double>(volume.Grid.GetNumberOfVertices()) *
      static_cast<double>(GetValueSize(array.Type)) * array.Components;
  }
  BlockedVolumeSettings settings = options.Settings;
  settings.Lines = volume.Lines;
  if (!settings.Time)
  {
    settings.Time = volume.Time;
  }
  settings.MemoryLimit -= volume.HeldBytes;
  const bool isTold = ranks.GetRank() == 0 && !options.IsQuiet;
  double seconds = 0;
  const auto written = [&]
  {
    ProgressDisplay display(options.Output, sampleBytes, isTold);
    auto result = BlockedVolumeWriter(ranks).Write(
      options.Output, volume.Grid, volume.Arrays, *volume.Source, settings, display.GetProgress());
    seconds = display.GetSeconds();
    return result;
  }();
  ISOSURFACE_RETURN_IF_ERROR(written.GetStatus());
  if (isTold)
  {
    const auto bytes = static_cast<double>(written->Bytes);
    std::printf("%s: %llu blocks of %d cells a side in %zu stores, %s (%s of samples), %.1f s, "
                "%.0f MB/s\n",
      options.Output.c_str(), static_cast<unsigned long long>(written->Blocks), settings.BlockSize,
      written->Stores.size(), FormatBytes(bytes).c_str(), FormatBytes(sampleBytes).c_str(), seconds,
      sampleBytes / 1e6 / std::max(seconds, 1e-9));
  }
  return Status::Ok();
}

} // namespace

Status RunWriteCommand(const BlockVolumeOptions& options, Communicator& ranks)
{
  const std::size_t first = options.Step.value_or(0);
  auto volume = InputVolume::Open(options, first);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(volume.GetStatus()));
  if (ranks.GetRank() == 0 && !options.IsQuiet && !volume->LeftOut.empty())
  {
    std::fprintf(stderr, "blockvolume: %s: %s\n", options.Input.c_str(), volume->LeftOut.c_str());
  }
  const std::size_t steps = options.Step ? 1 : std::max<std::size_t>(1, volume->Times.size());
  if (steps > 1 && options.Settings.Time)
  {
    return Status(StatusCode::InvalidArgument,
      "--time: " + options.Input + " has " + std::to_string(steps) +
        " time steps; --step chooses one");
  }
  ISOSURFACE_RETURN_IF_ERROR(WriteStep(options, std::move(*volume), ranks));
  BlockVolumeOptions next = options;
  next.Settings.Append = true;
  for (std::size_t step = first + 1; step < first + steps; ++step)
  {
    auto more = InputVolume::Open(next, step);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(more.GetStatus()));
    ISOSURFACE_RETURN_IF_ERROR(WriteStep(next, std::move(*more), ranks));
  }
  return Status::Ok();
}

} // namespace isosurface
