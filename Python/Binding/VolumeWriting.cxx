// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeWriting.h"

#include "PythonErrors.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/OutputCheck.h"

namespace isosurface
{

template <typename OpenT>
void VolumeWriting::WriteStep(BlockedVolumeWriter& writer, BlockedVolumeSettings settings,
  const std::vector<ArrayDescription>& arrays, const OpenT& open,
  const std::function<void()>& rethrow) const
{
  SignalWatch watch;
  settings.Warn = [&watch](const std::string& warning) { watch.Warn(warning); };
  Status status;
  {
    const WorkWithoutGil released;
    status = Attempt(this->Path,
      [&]() -> Status
      {
        ISOSURFACE_ASSIGN_OR_RETURN(const auto source, open(settings));
        return writer.Write(this->Path, this->Grid, arrays, *source, settings, watch.GetProgress())
          .GetStatus();
      });
  }
  watch.Rethrow();
  rethrow();
  ThrowIfError(status);
}

template <typename StepT>
void VolumeWriting::WriteSteps(
  const std::vector<std::optional<double>>& times, const StepT& writeStep) const
{
  SerialCommunicator alone;
  BlockedVolumeWriter writer(alone);
  BlockedVolumeSettings settings = this->Settings;
  for (std::size_t step = 0; step < times.size(); ++step)
  {
    settings.Time = times[step];
    settings.Publish = step + 1 == times.size();
    writeStep(writer, settings, step);
    settings.Append = true;
  }
}

void VolumeWriting::WriteArrays(const std::vector<ArrayDescription>& descriptions,
  const std::vector<std::vector<ArrayLike>>& steps, const std::vector<std::optional<double>>& times,
  const std::optional<Index3>& chunk) const
{
  this->WriteSteps(times,
    [&](BlockedVolumeWriter& writer, const BlockedVolumeSettings& settings, std::size_t step)
    {
      ArrayLikeSource source(steps[step], this->Grid.GetDimensions(), chunk);
      const auto open = [&](BlockedVolumeSettings&) { return Result<ArrayLikeSource*>(&source); };
      this->WriteStep(writer, settings, descriptions, open, [&] { source.Rethrow(); });
    });
}

void VolumeWriting::WriteFile(
  VolumeFile& file, const std::vector<std::optional<double>>& times) const
{
  this->WriteSteps(times,
    [&](BlockedVolumeWriter& writer, const BlockedVolumeSettings& settings, std::size_t step)
    {
      const auto open = [&](BlockedVolumeSettings& ofStep) -> Result<std::unique_ptr<BoxSource>>
      {
        auto source = file.OpenSource(step, ofStep.Threads, ofStep.MemoryLimit);
        ofStep.Files = file.GetSourceFiles(step);
        for (const std::string& path : ofStep.Files.Paths)
        {
          ISOSURFACE_RETURN_IF_ERROR(CheckIsOther(this->Path, path));
        }
        return source;
      };
      this->WriteStep(writer, settings, file.GetArrays(), open, [] {});
    });
}

} // namespace isosurface
