// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeCommands.h"

#include "InputVolume.h"
#include "ProgressDisplay.h"
#include "Sandbox.h"
#include "StopSignal.h"

#include "Formats/Indexing/FetchBudget.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Opener/VolumePart.h"
#include "Ground/Base/OutputCheck.h"
#include "Ground/Base/PrintableText.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/VolumeName.h"
#include "Storage/Store/ChunkedSource.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

namespace isosurface
{

namespace
{

/// Has several threads decode the input. Returns what a volume in place has to know of it; nothing if the
/// volume is to have the samples itself.
Result<std::optional<SourceRecord>> PrepareInput(
  const BlockVolumeOptions& options, InputVolume& volume, std::size_t step, int threads)
{
  FileSystem& files = GetLocalFileSystem();
  if (options.IsInPlace && !IsForeignVolume(files, options.Input))
  {
    return Status(StatusCode::Unsupported,
      options.Input + ": cannot be indexed in place: VTK reads it, and as a whole");
  }
  SourceRecord wanted;
  wanted.Axes = options.Axes;
  wanted.Step = step;
  for (const ArrayDescription& array : volume.Arrays)
  {
    wanted.Arrays.push_back(array.Name);
  }
  std::optional<SourceRecord> inPlace;
  if (options.IsInPlace)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(inPlace,
      DescribeSource(files, OpenForeignVolume, options.Output, options.Input, wanted, volume.Grid,
        volume.Arrays));
  }
  ISOSURFACE_RETURN_IF_ERROR(ChunkedSource::Replace(volume.Source, files, OpenForeignVolume,
    options.Output, options.Input, inPlace.value_or(wanted), volume.Grid, volume.Arrays,
    { options.Settings.MemoryLimit / 4, threads, {} }));
  return inPlace;
}

/// What is written must not be what is read.
Status CheckOutput(const BlockVolumeOptions& options, const InputVolume& volume)
{
  ISOSURFACE_RETURN_IF_ERROR(
    CheckIsOther(options.Output, VolumeName::Parse(GetLocalFileSystem(), options.Input).Path));
  for (const std::string& file : volume.Files.Paths)
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckIsOther(options.Output, file));
  }
  return Status::Ok();
}

/// What was written of a volume.
std::string FormatWritten(const WriteStatistics& written, bool isInPlace)
{
  const auto bytes = static_cast<double>(written.Bytes);
  const auto overviewBytes = static_cast<double>(written.OverviewBytes);
  return isInPlace ? "in place, " + DescribeBytes(overviewBytes) + " of coarser levels"
                   : DescribeBytes(bytes);
}

/// The time steps of a run, and what it may fetch for all of them.
struct WrittenSteps
{
  std::size_t First;
  std::size_t Count;
  FetchBudget Fetching;
};

/// Writes one time step of the input.
Status WriteStep(const BlockVolumeOptions& options, InputVolume volume, std::size_t step,
  WrittenSteps& all, Communicator& ranks, BlockedVolumeWriter& writer)
{
  double sampleBytes = 0;
  for (const ArrayDescription& array : volume.Arrays)
  {
    sampleBytes += static_cast<double>(volume.Grid.GetNumberOfVertices()) *
      static_cast<double>(GetValueSize(array.Type)) * array.Components;
  }
  BlockedVolumeSettings settings = options.Settings;
  settings.Lines = volume.Lines;
  settings.Files = volume.Files;
  if (!settings.Time)
  {
    settings.Time = volume.Time;
  }
  settings.MemoryLimit -= volume.HeldBytes;
  settings.Threads = ranks.ChooseThreads(settings.Threads);
  auto inPlace = PrepareInput(options, volume, step, settings.Threads);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(inPlace.GetStatus()));
  settings.InPlace = std::move(*inPlace);
  if (settings.InPlace)
  {
    settings.JournalSeconds = BlockedVolumeSettings::UsualJournalSeconds;
  }
  all.Fetching.SetSampleBytes(all.Count * static_cast<std::uint64_t>(sampleBytes));
  settings.Warn = [](const std::string& warning)
  { std::fprintf(stderr, "blockvolume: warning: %s\n", MakePrintable(warning).c_str()); };
  const bool isTold = ranks.GetRank() == 0 && !options.IsQuiet;
  ProgressDisplay display(options.Output, sampleBytes, isTold);
  const Progress look = [](double) { return !IsStopAsked(); };
  const ReadingStop stop(look);
  std::optional<WriteStatistics> written;
  const auto write = [&](const Progress& advance) -> Status
  {
    const Progress progress = [&, show = display.GetProgress()](double share)
    {
      const double done = static_cast<double>(step - all.First) + share;
      return show(share) && advance(done / static_cast<double>(all.Count));
    };
    ISOSURFACE_ASSIGN_OR_RETURN(written,
      writer.Write(options.Output, volume.Grid, volume.Arrays, *volume.Source, settings,
        RenewTimeWith(progress)));
    return Status::Ok();
  };
  const Status status = all.Fetching.Run(ranks, look, write);
  const double seconds = display.GetSeconds();
  display.Clear();
  ISOSURFACE_RETURN_IF_ERROR(status);
  if (isTold && written->Stores.empty())
  {
    std::printf("%s: time step %zu was finished by an earlier run\n", options.Output.c_str(), step);
  }
  else if (isTold)
  {
    std::printf("%s: %llu blocks of %d cells a side in %zu stores, %s (%s of samples), %.1f s, "
                "%.0f MB/s\n",
      options.Output.c_str(), static_cast<unsigned long long>(written->Blocks), settings.BlockSize,
      written->Stores.size(), FormatWritten(*written, options.IsInPlace).c_str(),
      DescribeBytes(sampleBytes).c_str(), seconds, sampleBytes / 1e6 / std::max(seconds, 1e-9));
    if (all.Fetching.CountFetched() > 0)
    {
      std::printf("%s: %s\n", options.Input.c_str(), all.Fetching.Describe().c_str());
    }
  }
  return Status::Ok();
}

} // namespace

Status RunWriteCommand(const BlockVolumeOptions& given, Communicator& ranks)
{
  BlockVolumeOptions options = given;
  if (given.Region)
  {
    if (given.Raw || given.Spacing || given.Origin)
    {
      return Status(StatusCode::InvalidArgument,
        "--region is a box in the file's own coordinates, without --raw, --spacing and --origin");
    }
    const auto part = FindPart(GetLocalFileSystem(), given.Input, given.Axes, {}, *given.Region);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(part.GetStatus()));
    options.Input = *part;
  }
  const std::size_t first = options.Step.value_or(0);
  auto volume = InputVolume::Open(options, first);
  const std::size_t steps =
    options.Step || !volume.IsOk() ? 1 : std::max<std::size_t>(1, volume->Times.size());
  // So many steps are written, each by all ranks.
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(volume.IsOk() ? CheckOutput(options, *volume) : volume.GetStatus(),
      { { steps, options.Input + ": the ranks see different numbers of time steps" } }));
  if (steps > 1 && options.Settings.Time)
  {
    return Status(StatusCode::InvalidArgument,
      "--time: " + options.Input + " has " + std::to_string(steps) +
        " time steps; --step chooses one");
  }
  if (ranks.GetRank() == 0 && !options.IsQuiet && !volume->LeftOut.empty())
  {
    std::fprintf(stderr, "blockvolume: %s: %s\n", options.Input.c_str(),
      MakePrintable(volume->LeftOut).c_str());
  }
  // All become visible with the last one, so that an error of any leaves an older volume.
  BlockedVolumeWriter writer(ranks);
  BlockVolumeOptions next = options;
  next.Settings.Publish = steps == 1;
  WrittenSteps all{ first, steps, { options.Input, options.FetchBudget << 20 } };
  ISOSURFACE_RETURN_IF_ERROR(WriteStep(next, std::move(*volume), first, all, ranks, writer));
  next.Settings.Append = true;
  for (std::size_t step = first + 1; step < first + steps; ++step)
  {
    auto more = InputVolume::Open(next, step);
    ISOSURFACE_RETURN_IF_ERROR(
      ranks.Agree(more.IsOk() ? CheckOutput(options, *more) : more.GetStatus()));
    next.Settings.Publish = step + 1 == first + steps;
    ISOSURFACE_RETURN_IF_ERROR(WriteStep(next, std::move(*more), step, all, ranks, writer));
  }
  return Status::Ok();
}

} // namespace isosurface
