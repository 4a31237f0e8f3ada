// SPDX-License-Identifier: BSD-3-Clause
#include "InputVolume.h"

#include "PipelineInput.h"

#include "Source/VolumeFile.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

Result<VolumeFile> OpenRaw(const RawVolume& raw)
{
  auto source = raw.Open(GetLocalFileSystem());
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  VolumeFile file;
  file.Grid = raw.Grid;
  file.ArrayName = raw.ArrayName;
  file.Type = raw.Type;
  file.Source = std::move(*source);
  return file;
}

Result<InputVolume> OpenFile(const BlockVolumeOptions& options)
{
  auto file =
    options.Raw ? OpenRaw(*options.Raw) : VolumeFile::Open(GetLocalFileSystem(), options.Input);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  const auto arrays =
    ChooseArrays(options.Input, { { file->ArrayName, file->Type } }, options.Arrays);
  ISOSURFACE_RETURN_IF_ERROR(arrays.GetStatus());
  InputVolume volume;
  volume.Grid = file->Grid;
  volume.Arrays = *arrays;
  volume.Source = std::move(file->Source);
  return volume;
}

} // namespace

Result<InputVolume> InputVolume::Open(const BlockVolumeOptions& options)
{
  std::error_code error;
  if (!std::filesystem::is_directory(options.Input, error))
  {
    ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(options.Input, "read"));
  }
  const bool isFile = options.Raw || VolumeFile::IsKnown(GetLocalFileSystem(), options.Input);
  auto volume = isFile ? OpenFile(options)
                       : OpenPipelineInput(options.Input, options.Arrays, options.WithCells,
                           options.Settings.MemoryLimit / 4);
  if (volume.IsOk())
  {
    volume->Grid.Spacing = options.Spacing.value_or(volume->Grid.Spacing);
    volume->Grid.Origin = options.Origin.value_or(volume->Grid.Origin);
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
      std::string known;
      for (const ArrayDescription& array : arrays)
      {
        known.append(known.empty() ? "\"" : ", \"").append(array.Name).append("\"");
      }
      return Status(
        StatusCode::NotFound, path + ": has no numeric point array \"" + name + "\", but " + known);
    }
    chosen.push_back(*found);
  }
  return chosen;
}

} // namespace isosurface
