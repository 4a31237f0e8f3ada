// SPDX-License-Identifier: BSD-3-Clause
#include "InputVolume.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Opener/VolumeFormat.h"
#include "Formats/Source/FolderFiles.h"
#include "Ground/Volume/VolumeName.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

Result<InputVolume> OpenFile(const BlockVolumeOptions& options, std::size_t step)
{
  VolumeChoice choice;
  choice.Step = step;
  choice.Axes = options.Axes;
  choice.IgnoresPlaces = options.Spacing.has_value();
  choice.Arrays = options.Arrays;
  choice.CacheBytes = options.Settings.MemoryLimit / 4;
  ISOSURFACE_ASSIGN_OR_RETURN(auto file,
    options.Raw ? options.Raw->OpenVolume(GetLocalFileSystem())
                : OpenForeignVolume(GetLocalFileSystem(), options.Input, choice));
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto arrays, ChooseArrays(options.Input, file.Arrays, options.Arrays));
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto files, SourceFiles::Find(GetLocalFileSystem(), std::move(file.Files)));
  InputVolume volume;
  volume.Files = std::move(files);
  volume.Grid = file.Grid;
  volume.Lines = std::move(file.Lines);
  volume.Arrays = arrays;
  volume.LeftOut = file.LeftOut;
  volume.Times = file.Times;
  if (step < file.Times.size())
  {
    volume.Time = file.Times[step];
  }
  volume.Source = std::move(file.Source);
  return volume;
}

} // namespace

Result<InputVolume> InputVolume::Open(const BlockVolumeOptions& options, std::size_t step)
{
  const std::string path = VolumeName::Parse(GetLocalFileSystem(), options.Input).Path;
  std::error_code error;
  if (!std::filesystem::is_directory(path, error))
  {
    ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  }
  if (!options.Raw)
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckReadable(GetLocalFileSystem(), path));
  }
  const bool isFile = options.Raw || IsForeignVolume(GetLocalFileSystem(), options.Input);
  const bool isPlain = options.Raw || !isFile;
  if (isPlain && !options.Axes.empty())
  {
    return Status(StatusCode::InvalidArgument,
      "--axes: " + options.Input + " is no file of HDF5, NetCDF or Zarr");
  }
  if (isPlain && step > 0 && !IsPattern(GetLocalFileSystem(), options.Input))
  {
    return Status(
      StatusCode::InvalidArgument, "--step: " + options.Input + " is read as one time step");
  }
  auto volume = isFile ? OpenFile(options, step)
                       : OpenPipelineInput(options.Input, step, options.Arrays, options.WithCells,
                           options.Settings.MemoryLimit / 4);
  if (volume.IsOk())
  {
    if (volume->Lines && options.Origin && !options.Spacing)
    {
      return Status(StatusCode::InvalidArgument,
        "--origin: " + options.Input +
          " is a rectilinear grid, whose coordinates place it; with --spacing it becomes a regular "
          "one");
    }
    if (options.Spacing)
    {
      volume->Lines.reset();
    }
    if (options.Spacing || options.Unit != LengthUnit::Unknown)
    {
      // A spacing is in whatever unit the user has in mind.
      volume->Grid.Unit = options.Unit;
    }
    volume->Grid.Spacing = options.Spacing.value_or(volume->Grid.Spacing);
    volume->Grid.Origin = options.Origin.value_or(volume->Grid.Origin);
    if (const char* fault = volume->Lines ? nullptr : volume->Grid.FindFault())
    {
      return Status(StatusCode::InvalidArgument,
        options.Input + ": its grid " + fault + "; --spacing and --origin place it");
    }
  }
  return volume;
}

Result<std::vector<ArrayDescription>> ChooseArrays(const std::string& path,
  const std::vector<ArrayDescription>& arrays, const std::vector<std::string>& names)
{
  if (names.empty())
  {
    return arrays;
  }
  std::vector<ArrayDescription> chosen;
  for (const std::string& name : names)
  {
    const auto found = std::find_if(arrays.begin(), arrays.end(),
      [&name](const ArrayDescription& array) { return array.Name == name; });
    if (found == arrays.end())
    {
      std::string reason = ": has no numeric point array \"" + name + "\", but ";
      const char* separator = "\"";
      for (const ArrayDescription& array : arrays)
      {
        reason.append(separator).append(array.Name).append("\"");
        separator = ", \"";
      }
      return Status(StatusCode::NotFound, path + reason);
    }
    chosen.push_back(*found);
  }
  return chosen;
}

} // namespace isosurface
