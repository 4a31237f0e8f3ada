// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/ForeignVolume.h"

#include "Formats/Opener/VolumeFormat.h"

#include <algorithm>

namespace isosurface
{
namespace
{

Result<OpenedVolume> OpenFormat(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  const VolumeFormat* const format = FindVolumeFormat(files, name);
  if (!format)
  {
    return Status(StatusCode::Unsupported,
      name.Path +
        ": cannot be read: it is neither MetaImage, NRRD, TIFF, nor of another format by "
        "its name or first bytes");
  }
  if (!choice.Axes.empty() && !format->TakesAxes && !choice.IsRecorded)
  {
    return Status(StatusCode::InvalidArgument,
      name.GetText() + ": cannot be read with the axes \"" + choice.Axes + "\": those of " +
        std::string(format->Name) + " files are given");
  }
  const auto functions = format->Load(name.Path);
  ISOSURFACE_RETURN_IF_ERROR(functions.GetStatus());
  if (!name.Within.empty() && !functions->List)
  {
    return Status(StatusCode::InvalidArgument,
      name.GetText() + ": cannot be read: a file of this format has one volume, and no \"" +
        name.Within + "\"");
  }
  return functions->Open(files, name, choice);
}

Result<std::vector<VolumeListing>> ListFormat(FileSystem& files, const VolumeName& name)
{
  const VolumeFormat* const format = FindVolumeFormat(files, name);
  const auto functions = format ? format->Load(name.Path) : FormatFunctions();
  ISOSURFACE_RETURN_IF_ERROR(functions.GetStatus());
  if (!functions->List)
  {
    return Status(StatusCode::Unsupported,
      name.GetText() + ": cannot be listed: it is a file of one volume, or of an unknown format");
  }
  return functions->List(files, name);
}

} // namespace

bool IsForeignVolume(FileSystem& files, const std::string& name)
{
  return FindVolumeFormat(files, VolumeName::Parse(files, name)) != nullptr;
}

Result<OpenedVolume> OpenForeignVolume(
  FileSystem& files, const std::string& text, const VolumeChoice& choice)
{
  const VolumeName name = VolumeName::Parse(files, text);
  // What a file asks for may be more than there is, and libraries throw.
  auto volume = Attempt(text, [&] { return OpenFormat(files, name, choice); });
  if (volume.IsOk() && choice.Step >= std::max<std::size_t>(1, volume->Times.size()))
  {
    return Status(StatusCode::InvalidArgument,
      text + ": has " + std::to_string(std::max<std::size_t>(1, volume->Times.size())) +
        " time steps, and none of number " + std::to_string(choice.Step));
  }
  if (volume.IsOk() && volume->Files.empty())
  {
    volume->Files = { name.Path };
  }
  return volume;
}

Result<std::vector<VolumeListing>> ListForeignVolumes(FileSystem& files, const std::string& text)
{
  return Attempt(text, [&] { return ListFormat(files, VolumeName::Parse(files, text)); });
}

} // namespace isosurface
