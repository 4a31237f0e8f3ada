// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/ForeignVolume.h"

#include "Formats/Opener/VolumeFormat.h"
#include "Formats/Opener/VolumePart.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/SliceFiles.h"

#include <algorithm>
#include <numeric>

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
    ISOSURFACE_RETURN_IF_ERROR(CheckReadable(files, name.Path));
    const std::string kind =
      SliceFiles::FindKind(IsPattern(files, name.Path) ? FindFittingNames(files, name.Path, nullptr)
                                                       : ListNames(files, name.Path));
    if (!kind.empty())
    {
      return Status(StatusCode::Unsupported,
        name.Path + ": cannot be read in place: its slices are " + kind +
          " files; copy them: blockvolume " + name.Path + " OUT.bvol");
    }
    return Status(StatusCode::Unsupported,
      name.Path + ": cannot be read: by its name and first bytes it is of none of these: " +
        ListFormatNames() + ". What VTK reads (.vti, .vtk, ...) can be copied: blockvolume " +
        name.Path + " OUT.bvol");
  }
  if (!choice.Axes.empty() && !format->TakesAxes && !choice.IsRecorded)
  {
    return Status(StatusCode::InvalidArgument,
      name.GetText() + ": cannot be read with the axes \"" + choice.Axes + "\": those of " +
        std::string(format->Name) + " files are given");
  }
  if (IsAddress(name.Path) && format->IsLocal)
  {
    return Status(StatusCode::Unsupported,
      name.Path + ": cannot be read: " + std::string(format->Name) +
        " is read from a disk alone; download it, and open the copy");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto functions, format->Load(name.Path));
  if (!name.Within.empty() && !functions.List)
  {
    return Status(StatusCode::InvalidArgument,
      name.GetText() + ": cannot be read: a file of this format has one volume, and no \"" +
        name.Within + "\"");
  }
  return functions.Open(files, name, choice);
}

/// One of several files, each of which is a time step.
Result<OpenedVolume> OpenStepFile(FileSystem& files, const VolumeName& name,
  const std::vector<std::string>& steps, const VolumeChoice& choice, const PassedOver& over)
{
  VolumeChoice one = choice;
  one.Step = 0;
  const std::string& path = steps[std::min(choice.Step, steps.size() - 1)];
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, OpenFormat(files, { path, name.Within }, one));
  if (volume.Times.size() > 1)
  {
    return Status(StatusCode::Unsupported,
      path + ": cannot be read as a time step of " + name.Path + ": it has " +
        std::to_string(volume.Times.size()) + " time steps itself");
  }
  const std::string passed = over.GetText();
  volume.LeftOut += (volume.LeftOut.empty() || passed.empty() ? "" : "; ") + passed;
  volume.LeftOut += std::string(volume.LeftOut.empty() ? "" : "; ") + "the " +
    std::to_string(steps.size()) + " files are time steps, numbered from 0";
  volume.Files = { path };
  volume.Times.resize(steps.size());
  std::iota(volume.Times.begin(), volume.Times.end(), 0.0);
  return volume;
}

Result<OpenedVolume> OpenFormatOrSteps(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  PassedOver over;
  const std::vector<std::string> steps = FindStepFiles(files, name.Path, &over);
  return steps.empty() ? OpenFormat(files, name, choice)
                       : OpenStepFile(files, name, steps, choice, over);
}

/// A volume, or a part of it. The part of a pyramid is of its finest level.
Result<OpenedVolume> OpenPartOf(FileSystem& files, VolumeName name, VolumeChoice choice)
{
  const std::string text = name.GetText();
  const auto part = TakePart(name.Within);
  choice.Vertices = part ? 0 : choice.Vertices;
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, OpenFormatOrSteps(files, name, choice));
  if (part)
  {
    if (part->IsEmpty() || !volume.Source->GetBox().Contains(*part))
    {
      const Index3 size = volume.Grid.GetDimensions();
      return Status(StatusCode::InvalidArgument,
        text + ": the volume has " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
          " x " + std::to_string(size[2]) + " samples, and no such part");
    }
    volume.Source = CutSource(std::move(volume.Source), *part);
    CutGrid(volume.Grid, volume.Lines, *part);
  }
  return volume;
}

Result<std::vector<VolumeListing>> ListFormat(FileSystem& files, const VolumeName& name)
{
  const VolumeFormat* const format = FindVolumeFormat(files, name);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto functions, format ? format->Load(name.Path) : FormatFunctions());
  if (!functions.List)
  {
    return Status(StatusCode::Unsupported,
      name.GetText() + ": cannot be listed: it is a file of one volume, or of an unknown format");
  }
  const std::vector<std::string> steps = FindStepFiles(files, name.Path);
  return functions.List(files, steps.empty() ? name : VolumeName{ steps.front(), name.Within });
}

} // namespace

bool IsForeignVolume(FileSystem& files, const std::string& name)
{
  VolumeName whole = VolumeName::Parse(files, name);
  TakePart(whole.Within);
  return FindVolumeFormat(files, whole) != nullptr;
}

Result<OpenedVolume> OpenForeignVolume(
  FileSystem& files, const std::string& text, const VolumeChoice& choice)
{
  const VolumeName name = VolumeName::Parse(files, text);
  // What a file asks for may be more than there is, and libraries throw.
  auto volume = Attempt(text, [&] { return OpenPartOf(files, name, choice); });
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
