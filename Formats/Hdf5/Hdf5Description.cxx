// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5Description.h"

#include "Formats/Source/TextFields.h"
#include "Formats/Zarr/JsonField.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace isosurface
{
namespace
{

using Numbers = StoredArray::Numbers;

std::string FindGroup(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos || slash == 0 ? "/" : path.substr(0, slash);
}

std::string FindName(const std::string& path)
{
  return path.substr(path.rfind('/') + 1);
}

/// An attribute of one whole number, which Imaris writes as text.
std::int64_t ReadCount(const Hdf5File& file, const std::string& object, const std::string& name)
{
  const auto text = file.ReadText(object, name);
  const std::int64_t count = text ? ParseInteger(TrimText(*text)).value_or(0) : 0;
  return std::max<std::int64_t>(0, count);
}

/// What a file says of one axis of a dataset.
struct AxisWords
{
  std::string Name;
  std::vector<double> Coordinates; ///< perhaps empty
  double Step = 0;                 ///< in place of coordinates; 0: not known
  std::string Unit;
};

class DescriptionReader
{
public:
  DescriptionReader(const Hdf5File& file, std::string path, const Numbers& shape)
    : File(file)
    , Path(std::move(path))
    , Group(FindGroup(this->Path))
    , Shape(shape)
    , Axes(shape.size())
  {
  }

  Hdf5Description Read(const std::string& letters)
  {
    this->ReadScales();
    this->ReadNexus();
    this->ReadEmd();
    this->ReadTags();
    std::string told;
    const std::string likely = letters.empty() ? this->FindLetters(told) : letters;
    if (const auto axes = ArrayAxes::Parse(likely, this->Shape.size()); axes.IsOk())
    {
      const int places[] = { axes->X, axes->Y, axes->Z };
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const auto place = static_cast<std::size_t>(places[axis]);
        this->TakePlace(axis, this->Axes[place], this->Shape[place]);
      }
      this->TakeTimes(*axes);
    }
    this->ReadElementSize();
    this->ReadDream3d();
    this->ReadItk();
    this->ReadImaris();
    this->ReadPrograms();
    const bool isGiven = !this->Found.Letters.empty() && letters.empty();
    this->Found.Letters = isGiven ? this->Found.Letters : likely;
    if (!isGiven && !told.empty())
    {
      this->Found.AddNote(told);
    }
    return std::move(this->Found);
  }

private:
  /// Takes the coordinates in a dataset for an axis, unless it has some.
  void TakeScale(std::size_t axis, const std::string& path)
  {
    AxisWords& words = this->Axes[axis];
    if (path.empty() || !words.Coordinates.empty() || !this->File.Has(path) ||
      !this->File.IsDataset(path))
    {
      return;
    }
    words.Name = words.Name.empty() ? this->File.ReadText(path, "name").value_or("") : words.Name;
    words.Name = words.Name.empty() ? FindName(path) : words.Name;
    words.Unit = this->File.ReadText(path, "units").value_or("");
    if (this->File.ReadText(path, "NAME").value_or("").rfind("This is a netCDF dimension", 0) == 0)
    {
      return; // without coordinates
    }
    constexpr std::int64_t largest = std::int64_t{ 1 } << 24;
    const std::int64_t most = std::min(largest, std::max<std::int64_t>(this->Shape[axis], 2));
    if (auto numbers = this->File.ReadList(path, most); numbers.IsOk())
    {
      words.Coordinates = std::move(*numbers);
    }
  }

  void ReadScales()
  {
    const std::vector<std::string> labels = this->File.ReadTexts(this->Path, "DIMENSION_LABELS");
    const std::vector<std::string> scales = this->File.FindScales(this->Path);
    for (std::size_t axis = 0; axis < this->Axes.size(); ++axis)
    {
      this->Axes[axis].Name = axis < labels.size() ? labels[axis] : "";
      this->TakeScale(axis, axis < scales.size() ? scales[axis] : "");
    }
  }

  void ReadNexus()
  {
    const std::string signal = this->File.ReadText(this->Group, "signal").value_or("");
    const std::vector<std::string> names = this->File.ReadTexts(this->Group, "axes");
    if (signal != FindName(this->Path) || names.size() != this->Axes.size())
    {
      return;
    }
    for (std::size_t number = 0; number < names.size(); ++number)
    {
      const auto index = this->File.ReadNumbers(this->Group, names[number] + "_indices", 1);
      const double axis = index ? index->front() : static_cast<double>(number);
      if (names[number] != "." && axis >= 0 && axis < static_cast<double>(names.size()))
      {
        this->Axes[static_cast<std::size_t>(axis)].Name = names[number];
        this->TakeScale(static_cast<std::size_t>(axis), this->Group + "/" + names[number]);
      }
    }
  }

  void ReadEmd()
  {
    if (!this->File.ReadNumbers(this->Group, "emd_group_type", 1) &&
      this->File.ReadText(this->Group, "emd_group_type") != "array")
    {
      return;
    }
    const std::size_t first = this->File.Has(this->Group + "/dim0") ? 0 : 1; // of version 1: 0
    for (std::size_t axis = 0; axis < this->Axes.size(); ++axis)
    {
      AxisWords& words = this->Axes[axis];
      this->TakeScale(axis, this->Group + "/dim" + std::to_string(axis + first));
      if (words.Coordinates.size() == 2 && this->Shape[axis] > 2) // the first two stand for all
      {
        words.Step = words.Coordinates[1] - words.Coordinates[0];
      }
    }
  }

  /// The axes of vigra and ilastik.
  void ReadTags()
  {
    const std::string text = this->File.ReadText(this->Path, "axistags").value_or("");
    const auto tags = nlohmann::json::parse(text, nullptr, false);
    const nlohmann::json& axes = FindJson(tags, "axes");
    if (text.empty() || !axes.is_array() || axes.size() != this->Axes.size())
    {
      return;
    }
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
    {
      const nlohmann::json& step = FindJson(axes[axis], "resolution");
      this->Axes[axis].Name = GetJsonText(FindJson(axes[axis], "key"));
      this->Axes[axis].Step = step.is_number() ? step.get<double>() : 0;
    }
  }

  std::string FindLetters(std::string& told) const
  {
    std::string letters;
    std::string names;
    bool isNamed = false;
    for (const AxisWords& words : this->Axes)
    {
      letters += ArrayAxes::FindLetter(words.Name);
      names += (names.empty() ? "" : ", ") + (words.Name.empty() ? "?" : words.Name);
      isNamed = isNamed || !words.Name.empty();
    }
    return ArrayAxes::Guess(this->Shape, letters, isNamed ? names : "", told);
  }

  void TakePlace(std::size_t axis, const AxisWords& words, std::int64_t size)
  {
    GridGeometry& place = this->Found.Place;
    double step = words.Step;
    double first = words.Coordinates.empty() ? 0 : words.Coordinates.front();
    if (step == 0 && size > 1 && static_cast<std::int64_t>(words.Coordinates.size()) == size)
    {
      const auto gaps = static_cast<double>(words.Coordinates.size() - 1);
      step = (words.Coordinates.back() - first) / gaps;
      // Coordinates may be floats of 32 bits.
      const double most = std::abs(step) * 1e-3 + std::abs(first) * 1e-6;
      double expected = first;
      for (const double coordinate : words.Coordinates)
      {
        step = std::abs(coordinate - expected) <= most ? step : 0;
        expected += step;
      }
    }
    if (!std::isfinite(step) || !std::isfinite(first) || step == 0)
    {
      if (words.Coordinates.size() > 1)
      {
        this->Found.AddNote("the coordinates of its axis " + words.Name +
          " are not one for each sample with equal steps, and are not used");
      }
      return;
    }
    place.Spacing[axis] = std::abs(step);
    place.Origin[axis] = first;
    place.Direction[4 * axis] = step < 0 ? -1 : 1;
    this->TakeUnit(words.Unit);
  }

  void TakeUnit(const std::string& unit)
  {
    if (!unit.empty() && !this->Found.Unit.empty() && unit != this->Found.Unit)
    {
      this->Found.AddNote("its axes have several units: " + this->Found.Unit + " and " + unit);
    }
    this->Found.Unit = this->Found.Unit.empty() ? unit : this->Found.Unit;
  }

  void TakeTimes(const ArrayAxes& axes)
  {
    const auto axis = static_cast<std::size_t>(std::max(axes.Time, 0));
    const AxisWords& words = this->Axes[axis];
    if (axes.Time < 0)
    {
      return;
    }
    if (static_cast<std::int64_t>(words.Coordinates.size()) == this->Shape[axis] &&
      std::all_of(words.Coordinates.begin(), words.Coordinates.end(),
        [](double time) { return std::isfinite(time); }))
    {
      this->Found.Times = words.Coordinates;
    }
    if (!words.Unit.empty())
    {
      this->Found.AddNote("the unit of times, " + words.Unit + ", is not kept");
    }
  }

  void ReadElementSize()
  {
    if (const auto size = this->File.ReadNumbers(this->Path, "element_size_um", 3))
    {
      const bool isSize = std::all_of(
        size->begin(), size->end(), [](double edge) { return std::isfinite(edge) && edge > 0; });
      if (isSize)
      {
        this->Found.Place.Spacing = { (*size)[2], (*size)[1], (*size)[0] };
        this->Found.Unit = "\u00B5m";
      }
    }
  }

  /// Three numbers: a dataset in a group, or an attribute of it.
  std::optional<std::vector<double>> ReadTriple(const std::string& group, const std::string& name)
  {
    const std::string path = group + "/" + name;
    if (this->File.Has(path) && this->File.IsDataset(path))
    {
      auto list = this->File.ReadList(path, 3);
      return list.IsOk() && list->size() == 3 ? std::optional(std::move(*list)) : std::nullopt;
    }
    return this->File.Has(group) ? this->File.ReadNumbers(group, name, 3) : std::nullopt;
  }

  /// Cells of DREAM.3D, and of DREAM3D-NX, whose group is that of the geometry.
  void ReadDream3d()
  {
    const std::string container = FindGroup(this->Group);
    const std::string group = container + "/_SIMPL_GEOMETRY";
    const bool isOld = this->File.Has(group);
    const std::string mark = isOld ? "" : "_";
    const std::string& geometry = isOld ? group : container;
    const auto spacing = this->ReadTriple(geometry, mark + "SPACING");
    const auto origin = this->ReadTriple(geometry, mark + "ORIGIN");
    const auto dimensions = this->ReadTriple(geometry, mark + "DIMENSIONS");
    const std::size_t rank = this->Shape.size();
    if (!spacing || !dimensions || rank < 3)
    {
      return;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      if (static_cast<double>(this->Shape[2 - axis]) != (*dimensions)[axis])
      {
        return; // of features, not of cells
      }
    }
    this->Found.Letters = rank == 4 ? "zyxc" : this->Found.Letters;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Found.Place.Spacing[axis] = (*spacing)[axis];
      this->Found.Place.Origin[axis] = (origin ? (*origin)[axis] : 0) + (*spacing)[axis] / 2;
    }
    this->Found.AddNote("samples are in the middle of DREAM.3D's cells, half a cell behind ORIGIN");
  }

  /// An image of ITK: x is the first of the numbers, and a row of Directions is the direction of an axis.
  void ReadItk()
  {
    const std::string path = this->Group + "/Directions";
    if (FindName(this->Path) != "VoxelData" || !this->File.Has(path))
    {
      return;
    }
    const auto spacing = this->ReadTriple(this->Group, "Spacing");
    const auto origin = this->ReadTriple(this->Group, "Origin");
    const auto directions = this->File.ReadList(path, 9, 2);
    if (!spacing || !origin || !directions.IsOk() || directions->size() != 9)
    {
      this->Found.AddNote(
        "ITK's Spacing, Origin and Directions are not those of three axes, and are "
        "not used");
      return;
    }
    this->Found.Letters = this->Shape.size() == 4 ? "zyxc" : this->Found.Letters;
    GridGeometry& place = this->Found.Place;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      place.Spacing[axis] = (*spacing)[axis];
      place.Origin[axis] = (*origin)[axis];
      for (std::size_t row = 0; row < 3; ++row)
      {
        place.Direction[3 * row + axis] = (*directions)[3 * axis + row];
      }
    }
  }

  void ReadImaris()
  {
    const Index3 size = FindSizeOfImaris(this->File, this->Group);
    if (size[0] > 0 && this->Shape.size() == 3 && FindName(this->Path) == "Data")
    {
      this->Found.Shape = { size[2], size[1], size[0] };
      FindPlaceOfImaris(this->File, size, this->Found);
    }
  }

  void ReadPrograms()
  {
    const bool isCells = FindName(this->Path) == "cells" && this->Path.size() > 7 &&
      this->Path[1] == 't' && this->Path.find("/s") != std::string::npos;
    if (isCells)
    {
      this->Found.IsUnsigned = true;
      this->Found.AddNote(
        "BigDataViewer's voxel sizes are in the .xml beside the file, which is not "
        "read: --spacing gives them");
    }
    if (this->File.ReadText(this->Path, "MATLAB_class"))
    {
      this->Found.AddNote("the first, second and third index in MATLAB are x, y and z here");
    }
    const std::string names = this->File.FindNumberNames(this->Path);
    if (!names.empty())
    {
      this->Found.AddNote("its samples are the numbers of an enumeration: " + names);
    }
    this->Found.SampleUnit = this->File.ReadText(this->Path, "units").value_or("");
  }

  const Hdf5File& File;
  std::string Path;
  std::string Group;
  const Numbers& Shape;
  std::vector<AxisWords> Axes;
  Hdf5Description Found;
};

} // namespace

Hdf5Description Hdf5Description::Read(const Hdf5File& file, const std::string& path,
  const StoredArray::Numbers& shape, const std::string& letters)
{
  return DescriptionReader(file, path, shape).Read(letters);
}

bool FindPlaceOfImaris(const Hdf5File& file, const Index3& size, Hdf5Description& description)
{
  const std::string image = "/DataSetInfo/Image";
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto end = [&](const char* name)
    {
      const auto text = file.Has(image) ? file.ReadText(image, name + std::to_string(axis))
                                        : std::optional<std::string>();
      return text ? ParseDouble(TrimText(*text)) : std::nullopt;
    };
    const auto low = end("ExtMin");
    const auto high = end("ExtMax");
    if (!low || !high || !(*high > *low) || !std::isfinite(*high - *low))
    {
      description.AddNote("Imaris' extents are missing or impossible: the spacing is 1");
      description.Place = GridGeometry();
      return false;
    }
    const double spacing = (*high - *low) / static_cast<double>(size[axis]);
    description.Place.Spacing[axis] = spacing;
    description.Place.Origin[axis] = *low + spacing / 2; // the extents are those of cells
  }
  description.Unit = TrimText(file.ReadText(image, "Unit").value_or(""));
  return true;
}

Index3 FindSizeOfImaris(const Hdf5File& file, const std::string& channel)
{
  return { ReadCount(file, channel, "ImageSizeX"), ReadCount(file, channel, "ImageSizeY"),
    ReadCount(file, channel, "ImageSizeZ") };
}

} // namespace isosurface
