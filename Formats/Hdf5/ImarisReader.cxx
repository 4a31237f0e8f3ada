// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/ImarisReader.h"

#include "Formats/Hdf5/Hdf5Description.h"
#include "Formats/Source/ArraySource.h"

#include <algorithm>

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

} // namespace

bool IsImaris(const Hdf5File& file)
{
  return file.Has("/DataSetInfo") && file.Has("/DataSet") && file.Has(NameLevel(0)) &&
    file.Has(NameLevel(0) + "/TimePoint 0") && file.Has(NameLevel(0) + "/TimePoint 0/Channel 0");
}

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
  std::vector<ArrayPart> parts;
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
      const auto made, MakeParts(names.back(), std::move(array), *axes, 0));
    parts.insert(parts.end(), made.begin(), made.end());
  }
  if (parts.empty())
  {
    return Status(StatusCode::NotFound,
      file.GetPath() + ":" + point + ": cannot be read: there are no channels of Imaris");
  }
  FindPlaceOfImaris(file, parts.front().GetDimensions(), description);
  ISOSURFACE_RETURN_IF_ERROR(TakeParts(std::move(parts), choice.Arrays, volume));
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

} // namespace isosurface
