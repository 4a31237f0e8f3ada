// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5Description.h"
#include "Formats/Hdf5/Hdf5File.h"
#include "Formats/Source/ArraySource.h"
#include "Formats/Source/FormatFunctions.h"
#include "Ground/Volume/VolumeOpener.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

std::string NameLevel(std::size_t level)
{
  return "/DataSet/ResolutionLevel " + std::to_string(level);
}

/// How many things of a group are named "`prefix` 0", "`prefix` 1" and so on.
std::size_t CountNames(const Hdf5File& file, const std::string& group, const std::string& prefix)
{
  const std::vector<std::string> names =
    file.Has(group) ? file.FindNames(group) : std::vector<std::string>();
  std::size_t count = 0;
  while (std::binary_search(names.begin(), names.end(), prefix + " " + std::to_string(count)))
  {
    ++count;
  }
  return count;
}

/// The finest level of at most so many vertices, or the coarsest.
std::size_t ChooseLevelOfImaris(const Hdf5File& file, std::int64_t vertices)
{
  const std::size_t levels = CountNames(file, "/DataSet", "ResolutionLevel");
  for (std::size_t level = 0; vertices > 0 && level < levels; ++level)
  {
    const Index3 size = FindSizeOfImaris(file, NameLevel(level) + "/TimePoint 0/Channel 0");
    const double samples =
      static_cast<double>(size[0]) * static_cast<double>(size[1]) * static_cast<double>(size[2]);
    if (samples <= static_cast<double>(vertices) || level + 1 == levels)
    {
      return samples > 0 ? level : 0;
    }
  }
  return 0;
}

/// Whether a file is of Imaris 5.5 or later.
bool IsImaris(const Hdf5File& file)
{
  return file.Has("/DataSetInfo") && file.Has("/DataSet") && file.Has(NameLevel(0)) &&
    file.Has(NameLevel(0) + "/TimePoint 0") && file.Has(NameLevel(0) + "/TimePoint 0/Channel 0");
}

/// Opens a file of Imaris: its channels are arrays, its time points time steps, its resolution levels a
/// pyramid. Datasets are larger than the image, which ImageSizeX, Y and Z of each channel tell.
Result<OpenedVolume> OpenImaris(const Hdf5File& file, const VolumeChoice& choice)
{
  OpenedVolume volume;
  volume.Grid.Extent = {};
  const std::size_t level = ChooseLevelOfImaris(file, choice.Vertices);
  volume.Level = static_cast<int>(level);
  const std::size_t steps = CountNames(file, NameLevel(level), "TimePoint");
  const std::string point = NameLevel(level) + "/TimePoint " + std::to_string(choice.Step);
  const std::size_t channels = CountNames(file, point, "Channel");
  Hdf5Description description;
  std::vector<VolumeArray> parts;
  std::vector<std::string> names;
  for (std::size_t channel = 0; channel < channels; ++channel)
  {
    const std::string number = std::to_string(channel);
    const std::string group = point + "/Channel " + number;
    const Index3 size = FindSizeOfImaris(file, group);
    const StoredArray::Numbers shape =
      size[0] > 0 ? StoredArray::Numbers{ size[2], size[1], size[0] } : StoredArray::Numbers();
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto array, file.OpenArray(group + "/Data", choice.CacheBytes / channels, shape, false));
    const std::string info = "/DataSetInfo/Channel " + number;
    const std::string said =
      file.Has(info) ? file.ReadText(info, "Name").value_or("") : std::string();
    const bool isNew = std::find(names.begin(), names.end(), said) == names.end();
    names.push_back(!said.empty() && isNew ? said : "channel " + number);
    const auto axes = ArrayAxes::Parse("zyx", array->GetShape().size());
    if (!axes.IsOk())
    {
      return Status(axes.GetStatus().GetCode(),
        array->GetName() + ": cannot be read: " + axes.GetStatus().GetMessage());
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto made, MakeVolumeArrays(names.back(), std::move(array), *axes, 0));
    parts.insert(parts.end(), made.begin(), made.end());
  }
  if (parts.empty())
  {
    return Status(StatusCode::NotFound,
      file.GetPath() + ":" + point + ": cannot be read: there are no channels of Imaris");
  }
  FindPlaceOfImaris(file, parts.front().GetDimensions(), description);
  ISOSURFACE_RETURN_IF_ERROR(TakeVolumeArrays(std::move(parts), choice.Arrays, volume));
  volume.Grid.Spacing = description.Place.Spacing;
  volume.Grid.Origin = description.Place.Origin;
  for (std::size_t step = 0; steps > 1 && step < steps; ++step)
  {
    volume.Times.push_back(static_cast<double>(step));
  }
  if (steps > 1)
  {
    description.AddNote("time points are numbered; the dates of Imaris are not used");
  }
  volume.Grid.Unit = FindLengthUnit(description.Unit);
  if (!description.Unit.empty() && volume.Grid.Unit == LengthUnit::Unknown)
  {
    description.AddNote("the unit of lengths, " + description.Unit + ", is not kept");
  }
  volume.LeftOut = description.Notes;
  return volume;
}

std::string GetLastPart(const std::string& path)
{
  const std::string name = path.substr(path.rfind('/') + 1);
  return name.empty() ? "data" : name;
}

Status AddObject(const VolumeName& name, const std::string& object, const Status& status)
{
  return Status(
    status.GetCode(), name.Path + ":" + object + ": cannot be read: " + status.GetMessage());
}

/// The dataset to read when the name gives none.
Result<std::string> FindOnlyDataset(const VolumeName& name, const Hdf5File& file)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto datasets, file.FindDatasets());
  std::string known;
  std::string refused;
  for (const Hdf5Dataset& dataset : datasets)
  {
    refused = refused.empty() ? dataset.Refusal : refused;
  }
  for (std::size_t rank = 3; rank <= 5; ++rank)
  {
    std::vector<std::string> fitting;
    for (const Hdf5Dataset& dataset : datasets)
    {
      const bool hasComponent = dataset.Shape.size() > 3 && dataset.Shape.back() == 1;
      if (dataset.IsNumeric && dataset.Shape.size() == rank + (hasComponent ? 1 : 0))
      {
        fitting.push_back(dataset.Path);
        known += (known.empty() ? "" : ", ") + dataset.Path + " (" + JoinNumbers(dataset.Shape) +
          " " + dataset.Type + ")";
      }
    }
    if (fitting.size() == 1)
    {
      return fitting.front();
    }
    if (!fitting.empty())
    {
      break;
    }
  }
  if (known.empty() && !refused.empty())
  {
    return Status(StatusCode::Unsupported, refused);
  }
  return Status(StatusCode::NotFound,
    name.Path + ": cannot be read: " +
      (known.empty() ? "it has no dataset of numbers with 3 to 5 axes"
                     : "name one of its datasets, as in " + name.Path + ":/path: " + known));
}

/// Finds the unit of lengths, and tells the attributes of a dataset that nothing here is read from.
void NoteAttributes(const Hdf5File& file, const std::string& path, Hdf5Description& description)
{
  const std::string used = " DIMENSION_LABELS DIMENSION_LIST axistags element_size_um MATLAB_class "
                           "ComponentDimensions TupleDimensions units ";
  std::string unused;
  for (const std::string& attribute : file.FindAttributes(path))
  {
    if (used.find(" " + attribute + " ") == std::string::npos)
    {
      unused += (unused.empty() ? "attributes that are not used: " : ", ") + attribute;
    }
  }
  description.Place.Unit = FindLengthUnit(description.Unit);
  if (!description.Unit.empty() && description.Place.Unit == LengthUnit::Unknown)
  {
    description.AddNote("the unit of lengths, " + description.Unit + ", is not kept");
  }
  if (!unused.empty())
  {
    description.AddNote(unused);
  }
}

Result<OpenedVolume> OpenDataset(
  const VolumeName& name, const Hdf5File& file, const std::string& path, const VolumeChoice& choice)
{
  if (path.compare(0, 10, "/minc-2.0/") == 0)
  {
    return AddObject(name, path,
      Status(StatusCode::Unsupported,
        "it is MINC, whose places and scale are not read: convert it to NIfTI, as mnc2nii does"));
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto shape, file.FindShape(path));
  Hdf5Description description = Hdf5Description::Read(file, path, shape, choice.Axes);
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto array, file.OpenArray(path, choice.CacheBytes, description.Shape, description.IsUnsigned));
  const auto axes = ArrayAxes::Parse(description.Letters, array->GetShape().size());
  if (!axes.IsOk())
  {
    return AddObject(name, path, axes.GetStatus());
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto parts, MakeVolumeArrays(GetLastPart(path), std::move(array), *axes, choice.Step));
  OpenedVolume volume;
  NoteAttributes(file, path, description);
  volume.Grid = description.Place;
  volume.Grid.Extent = {};
  volume.Times = std::move(description.Times);
  volume.LeftOut = description.Notes;
  volume.Attributes = choice.WantsAttributes ? file.DescribeAttributes(path) : "";
  ISOSURFACE_RETURN_IF_ERROR(TakeVolumeArrays(std::move(parts), choice.Arrays, volume));
  for (ArrayDescription& taken : volume.Arrays)
  {
    taken.Unit = description.SampleUnit;
  }
  return volume;
}

/// Reads image data of VTKHDF.
class VtkHdfReader
{
public:
  VtkHdfReader(const VolumeName& name, const Hdf5File& file, std::string group)
    : Name(name)
    , File(file)
    , Group(std::move(group))
  {
  }

  Result<OpenedVolume> Open(const VolumeChoice& choice)
  {
    const auto type = this->File.ReadText(this->Group, "Type");
    if (type != "ImageData")
    {
      return this->MakeError(StatusCode::Unsupported,
        "it is VTKHDF of type " + type.value_or("unknown") + ", of which ImageData alone is read");
    }
    if (!choice.Axes.empty())
    {
      return this->MakeError(StatusCode::InvalidArgument, "the axes of VTKHDF are given");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->TakeGrid());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeTimes());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeArrays(choice));
    if (!this->File.FindNames(this->Group + "/CellData").empty())
    {
      this->Volume.LeftOut = "cell arrays of VTKHDF are not read";
    }
    return std::move(this->Volume);
  }

private:
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return AddObject(this->Name, this->Group, Status(code, reason));
  }

  Status TakeGrid()
  {
    GridGeometry& grid = this->Volume.Grid;
    const auto extent = this->File.ReadNumbers(this->Group, "WholeExtent", 6);
    if (!extent)
    {
      return this->MakeError(StatusCode::Corrupt, "there is no WholeExtent of 6 numbers");
    }
    for (std::size_t side = 0; side < 6; ++side)
    {
      const double value = (*extent)[side];
      if (!(std::abs(value) <= 2147483647))
      {
        return this->MakeError(StatusCode::Corrupt, "its WholeExtent is impossible");
      }
      grid.Extent[side] = static_cast<std::int64_t>(value);
    }
    const auto take = [this](const char* attribute, auto& to)
    {
      const auto numbers = this->File.ReadNumbers(this->Group, attribute, to.size());
      if (numbers)
      {
        std::copy(numbers->begin(), numbers->end(), to.begin());
      }
    };
    take("Origin", grid.Origin);
    take("Spacing", grid.Spacing);
    take("Direction", grid.Direction);
    return Status::Ok();
  }

  /// The times of the group Steps, which temporal data have.
  Status TakeTimes()
  {
    const std::string path = this->Group + "/Steps/Values";
    if (!this->File.Has(this->Group + "/Steps") || !this->File.IsDataset(path))
    {
      return Status::Ok();
    }
    ISOSURFACE_ASSIGN_OR_RETURN(this->Volume.Times, this->File.ReadList(path, MaximumTimeSteps));
    return Status::Ok();
  }

  /// Where a time step is on the t axis of an array, which has `count` entries: several steps may have
  /// one entry.
  Result<std::size_t> FindEntry(
    const std::string& array, std::size_t step, std::int64_t count) const
  {
    const std::size_t steps = this->Volume.Times.size();
    const std::string group = this->Group + "/Steps/PointDataOffsets";
    const std::string path = group + "/" + array;
    if (step >= steps)
    {
      return this->MakeError(StatusCode::InvalidArgument,
        "it has " + std::to_string(steps) + " time steps, and none of number " +
          std::to_string(step));
    }
    if (!this->File.Has(group) || !this->File.Has(path))
    {
      return static_cast<std::size_t>(count) == steps
        ? Result<std::size_t>(step)
        : this->MakeError(StatusCode::Corrupt,
            "Steps/Values has " + std::to_string(steps) + " time steps, the point array " + array +
              " has " + std::to_string(count) + ", and no Steps/PointDataOffsets/" + array +
              " tells which is which");
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto offsets, this->File.ReadList(path, MaximumTimeSteps));
    const double offset = offsets.size() == steps ? offsets[step] : -1;
    if (!(offset >= 0 && offset < static_cast<double>(count) && std::trunc(offset) == offset))
    {
      return AddObject(this->Name, path,
        Status(StatusCode::Corrupt,
          offsets.size() == steps ? "time step " + std::to_string(step) + " has the number " +
              std::to_string(std::llround(offset)) + ", the point array has " +
              std::to_string(count) + " time steps from 0"
                                  : "it has " + std::to_string(offsets.size()) + " numbers for " +
              std::to_string(steps) + " time steps"));
    }
    return static_cast<std::size_t>(offset);
  }

  Status TakeArrays(const VolumeChoice& choice)
  {
    std::vector<VolumeArray> parts;
    const std::string group = this->Group + "/PointData";
    const std::string prefix = group + "/";
    const bool hasSteps = !this->Volume.Times.empty();
    const std::vector<std::string> names =
      this->File.Has(group) ? this->File.FindNames(group) : std::vector<std::string>();
    for (const std::string& array : names)
    {
      const std::string path = prefix + array;
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto stored, this->File.OpenArray(path, choice.CacheBytes / names.size()));
      const std::size_t spatial = 3 + (hasSteps ? 1 : 0);
      const std::size_t rank = stored->GetShape().size();
      const std::string letters =
        std::string(hasSteps ? "t" : "") + "zyx" + (rank > spatial ? "c" : "");
      const auto axes = ArrayAxes::Parse(letters, rank);
      if (!axes.IsOk())
      {
        return AddObject(this->Name, path, axes.GetStatus());
      }
      std::size_t entry = choice.Step;
      if (hasSteps)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(
          entry, this->FindEntry(array, choice.Step, stored->GetShape()[0]));
      }
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto made, MakeVolumeArrays(array, std::move(stored), *axes, entry));
      parts.insert(parts.end(), made.begin(), made.end());
    }
    if (parts.empty())
    {
      return this->MakeError(StatusCode::NotFound, "it has no point arrays");
    }
    const std::array<std::int64_t, 6> extent = this->Volume.Grid.Extent;
    ISOSURFACE_RETURN_IF_ERROR(TakeVolumeArrays(std::move(parts), choice.Arrays, this->Volume));
    return this->Volume.Grid.Extent == extent
      ? Status::Ok()
      : this->MakeError(StatusCode::Corrupt, "its point arrays do not have its WholeExtent");
  }

  const VolumeName& Name;
  const Hdf5File& File;
  std::string Group;
  OpenedVolume Volume;
};

Result<OpenedVolume> AddFiles(Result<OpenedVolume> volume, const Hdf5File& file)
{
  if (volume.IsOk())
  {
    volume->Files = file.FindFiles();
  }
  return volume;
}

Result<OpenedVolume> OpenHdf5Volume(
  FileSystem& /*files*/, const VolumeName& name, const VolumeChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, Hdf5File::Open(name.Path, choice.ReadsChunks));
  std::string path = name.Within;
  if (!path.empty() && path.front() != '/')
  {
    path.insert(0, 1, '/');
  }
  const std::string group = path.empty() ? "/VTKHDF" : path;
  if (file.Has(group) && !file.IsDataset(group) && file.ReadText(group, "Type"))
  {
    return AddFiles(VtkHdfReader(name, file, group).Open(choice), file);
  }
  if (path.empty() && IsImaris(file))
  {
    return choice.Axes.empty() || choice.IsRecorded
      ? AddFiles(OpenImaris(file, choice), file)
      : Status(StatusCode::InvalidArgument,
          name.GetText() + ": cannot be read: the axes of Imaris are given");
  }
  if (path.empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(path, FindOnlyDataset(name, file));
  }
  return AddFiles(OpenDataset(name, file, path, choice), file);
}

Result<std::vector<VolumeListing>> ListHdf5(FileSystem& /*files*/, const VolumeName& name)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, Hdf5File::Open(name.Path));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto datasets, file.FindDatasets());
  std::vector<VolumeListing> list;
  for (const Hdf5Dataset& dataset : datasets)
  {
    list.push_back({ dataset.Path, dataset.Shape.empty() ? "1" : JoinNumbers(dataset.Shape),
      dataset.Type, dataset.Storage });
  }
  return list;
}

} // namespace

/**
 * A volume in an HDF5 file:
 *
 *     file:/path     the dataset of that path, with 3 to 5 axes (ArrayAxes::Parse), as the file
 *                    describes it (Hdf5Description)
 *     file:/group    image data of VTKHDF, if the group is one
 *     file           image data of VTKHDF in /VTKHDF, the image of Imaris, or else the only dataset
 *                    of numbers with three axes, or the only one with four, or with five; a last axis
 *                    of one sample does not count
 *
 * VTKHDF (the file format of VTK's documentation, version 1 and 2): ImageData alone, with its extent,
 * origin, spacing, direction, point arrays and time steps.
 *
 * Errors: NotFound, with the datasets of the file, if it does not say which one is meant.
 */
extern "C" const FormatFunctions IsosurfaceHdf5Format;
const FormatFunctions IsosurfaceHdf5Format = { OpenHdf5Volume, ListHdf5 };

} // namespace isosurface
