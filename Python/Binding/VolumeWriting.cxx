// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeWriting.h"

#include "PythonErrors.h"

#include "Ground/Base/Communicator.h"

namespace isosurface
{

Status VolumeWriting::Write(
  const std::vector<ArrayDescription>& arrays, BoxSource& source, const Progress& progress) const
{
  SerialCommunicator alone;
  return BlockedVolumeWriter(alone)
    .Write(this->Path, this->Grid, arrays, source, this->Settings, progress)
    .GetStatus();
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
  SignalWatch watch;
  Status status;
  {
    const pybind11::gil_scoped_release released;
    const Progress progress = watch.GetProgress();
    status = Attempt(this->Path, [&] { return this->Write(descriptions, source, progress); });
  }
  source.Rethrow();
  watch.Rethrow();
  ThrowIfError(status);
}

void VolumeWriting::WriteFile(VolumeFile& file, std::size_t timeStep) const
{
  const int threads = this->Settings.Threads;
  RunWithoutGil(this->Path,
    [&](const Progress& progress) -> Status
    {
      const auto source = file.OpenSource(timeStep, threads);
      ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
      return this->Write(file.GetArrays(), **source, progress);
    });
}

} // namespace isosurface
