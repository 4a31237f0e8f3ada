// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeWriting.h"

#include "PythonErrors.h"

#include "Ground/Base/Communicator.h"

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
    const pybind11::gil_scoped_release released;
    status = Attempt(this->Path,
      [&]() -> Status
      {
        const auto source = open(settings);
        ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
        return writer.Write(this->Path, this->Grid, arrays, **source, settings, watch.GetProgress())
          .GetStatus();
      });
  }
  watch.Rethrow();
  rethrow();
  ThrowIfError(status);
}

void VolumeWriting::WriteArrays(const std::vector<ArrayDescription>& descriptions,
  const std::vector<ArrayLike>& arrays, const std::optional<Index3>& chunk) const
{
  ArrayLikeSource source(arrays, this->Grid.GetDimensions(), chunk);
  SerialCommunicator alone;
  BlockedVolumeWriter writer(alone);
  const auto open = [&](BlockedVolumeSettings&) { return Result<ArrayLikeSource*>(&source); };
  this->WriteStep(writer, this->Settings, descriptions, open, [&] { source.Rethrow(); });
}

void VolumeWriting::WriteFile(
  VolumeFile& file, const std::vector<std::optional<double>>& times) const
{
  SerialCommunicator alone;
  BlockedVolumeWriter writer(alone);
  BlockedVolumeSettings settings = this->Settings;
  for (std::size_t step = 0; step < times.size(); ++step)
  {
    settings.Time = times[step];
    settings.Publish = step + 1 == times.size();
    const auto open = [&](BlockedVolumeSettings& ofStep)
    {
      auto source = file.OpenSource(step, settings.Threads, settings.MemoryLimit);
      ofStep.Files = file.GetSourceFiles(step);
      return source;
    };
    this->WriteStep(writer, settings, file.GetArrays(), open, [] {});
    settings.Append = true;
  }
}

} // namespace isosurface
