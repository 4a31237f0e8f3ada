// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeWriting.h"

#include "PythonErrors.h"

#include "Ground/Base/Communicator.h"

namespace isosurface
{

template <typename OpenT>
void VolumeWriting::Write(const std::vector<ArrayDescription>& arrays, const OpenT& open,
  const std::function<void()>& rethrow) const
{
  SignalWatch watch;
  Status status;
  {
    const pybind11::gil_scoped_release released;
    status = Attempt(this->Path,
      [&]() -> Status
      {
        const auto source = open();
        ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
        BlockedVolumeSettings settings = this->Settings;
        settings.Warn = [&watch](const std::string& warning) { watch.Warn(warning); };
        SerialCommunicator alone;
        return BlockedVolumeWriter(alone)
          .Write(this->Path, this->Grid, arrays, **source, settings, watch.GetProgress())
          .GetStatus();
      });
  }
  watch.Rethrow();
  rethrow();
  ThrowIfError(status);
}

void VolumeWriting::WriteArrays(const std::vector<std::string>& names,
  const std::vector<ArrayLike>& arrays, const std::optional<Index3>& chunk) const
{
  std::vector<ArrayDescription> descriptions;
  for (std::size_t n = 0; n < arrays.size(); ++n)
  {
    descriptions.push_back({ names[n], arrays[n].Type, arrays[n].Components });
  }
  ArrayLikeSource source(arrays, this->Grid.GetDimensions(), chunk);
  this->Write(
    descriptions, [&] { return Result<ArrayLikeSource*>(&source); }, [&] { source.Rethrow(); });
}

void VolumeWriting::WriteFile(VolumeFile& file, std::size_t timeStep) const
{
  this->Write(
    file.GetArrays(), [&] { return file.OpenSource(timeStep, this->Settings.Threads); }, [] {});
}

} // namespace isosurface
