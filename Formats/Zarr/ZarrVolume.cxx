// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrVolume.h"

#include "Formats/Source/ArraySource.h"
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/TextFields.h"
#include "Formats/Zarr/JsonField.h"
#include "Formats/Zarr/ZarrArray.h"
#include "Formats/Zarr/ZarrPlace.h"
#include "Formats/Zarr/ZarrSearch.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

using Json = nlohmann::json;

/// Names of metadata, and the versions (ZarrNode) that have them; 0: what it says is known with the version.
constexpr std::pair<const char*, int> MetadataNames[] = { { "zarr.json", 3 }, { ".zarray", 2 },
  { ".zgroup", 0 }, { ".zattrs", 2 }, { "attributes.json", 5 } };

/// The paths of the metadata that a folder of a version may have; 0: of any.
std::vector<std::string> ListMetadata(const std::string& folder, int version)
{
  std::vector<std::string> paths;
  for (const auto& [name, of] : MetadataNames)
  {
    if (version == 0 || version == of)
    {
      paths.push_back(folder + "/" + name);
    }
  }
  return paths;
}

/// Of an image; each is compared with those before.
constexpr std::size_t MaximumAxes = 32;
constexpr std::size_t MaximumChannels = 1024;
constexpr std::size_t MaximumLevels = 32;

class ZarrReader
{
public:
  ZarrReader(FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
    : Files(files)
    , Name(name)
    , Choice(choice)
    , Folder(name.Path)
  {
    const std::size_t end = this->Folder.find_last_not_of('/');
    this->Folder.resize(end == std::string::npos ? 0 : end + 1);
    const std::size_t begin = name.Within.find_first_not_of('/');
    this->Folder += begin == std::string::npos ? "" : "/" + name.Within.substr(begin);
  }

  Result<OpenedVolume> Open()
  {
    this->Volume.Grid.Extent = {};
    ISOSURFACE_RETURN_IF_ERROR(this->OpenFolder(0));
    if (this->Choice.WantsAttributes)
    {
      this->Volume.Attributes =
        this->Attributes.dump(-1, ' ', false, Json::error_handler_t::replace);
    }
    return std::move(this->Volume);
  }

private:
  Status MakeError(StatusCode code, const std::string& folder, const std::string& reason) const
  {
    return Status(code, folder + ": cannot be read: " + reason);
  }

  /// Opens an array, an image, the first image of a conversion by bioformats2raw, or what else a
  /// folder has.
  Status OpenFolder(int depth)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto node, ZarrNode::Read(this->Files, this->Folder));
    if (node.IsArray)
    {
      return this->OpenLevel(node);
    }
    const Json& ome = FindOme(node);
    if (const Json& image = FindImage(ome); !image.is_null())
    {
      this->LookForLevels(FindJson(image, "datasets"), node.Version);
      this->TellOthers(ome, node.Version);
      this->Attributes = node.Attributes;
      return this->OpenImage(image, FindJson(ome, "omero"), std::nullopt, node.Version);
    }
    if (!FindJson(ome, "bioformats2raw.layout").is_null() && depth < MaximumZarrDepth)
    {
      return this->OpenSeries(depth);
    }
    return this->IsCollection(ome) ? this->MakeCollectionError(ome) : this->OpenOnlyArray(depth);
  }

  /// The images of bioformats2raw: those that OME/.zattrs names, or else 0, 1, 2 ...
  Status OpenSeries(int depth)
  {
    const auto metadata = ZarrNode::Read(this->Files, this->Folder + "/OME");
    std::vector<std::string> series = metadata.IsOk()
      ? ListPaths(FindJson(FindOme(*metadata), "series"))
      : std::vector<std::string>();
    for (std::size_t number = 0; series.size() == number && number < MaximumZarrArrays; ++number)
    {
      const std::string name = std::to_string(number);
      if (IsZarrFolder(this->Files, this->Folder + "/" + name))
      {
        series.push_back(name);
      }
    }
    if (series.empty())
    {
      return this->MakeError(
        StatusCode::Corrupt, this->Folder, "it is of bioformats2raw, and has no image");
    }
    if (series.size() > 1)
    {
      AddNote(this->Volume.LeftOut,
        "it has " + std::to_string(series.size()) + " images (" + JoinTexts(series) +
          "), of which the first one is read");
    }
    this->ArrayName = this->MakeName();
    this->Folder += "/" + series.front();
    return this->OpenFolder(depth + 1);
  }

  /// Whether it is a plate, a well or the labels of an image.
  bool IsCollection(const Json& ome) const
  {
    return FindJson(ome, "plate").is_object() || FindJson(ome, "well").is_object() ||
      (FindJson(ome, "labels").is_array() && GetLastPart(this->Folder) == "labels");
  }

  Status MakeCollectionError(const Json& ome) const
  {
    const bool isPlate = FindJson(ome, "plate").is_object();
    const bool isWell = FindJson(ome, "well").is_object();
    const std::vector<std::string> paths = isPlate
      ? ListPaths(FindJson(FindJson(ome, "plate"), "wells"), "path")
      : isWell ? ListPaths(FindJson(FindJson(ome, "well"), "images"), "path")
               : ListPaths(FindJson(ome, "labels"));
    const std::string what = isPlate ? "a plate of wells, each with images"
      : isWell                       ? "a well of images"
                                     : "labels of an image";
    return this->MakeError(StatusCode::NotFound, this->Folder,
      "it is " + what + ": name one of them, as in " + this->Name.Path + ":" +
        (paths.empty() ? "path"
                       : this->Name.Within + (this->Name.Within.empty() ? "" : "/") +
              paths.front() + (isPlate ? "/0" : "")) +
        "; it has " + JoinTexts(paths));
  }

  /// What an image at an address is made of is asked for at once.
  void LookForLevels(const Json& datasets, int version)
  {
    std::vector<std::string> folders = { this->Folder + "/labels" };
    for (std::size_t level = 0; level < std::min(datasets.size(), MaximumLevels); ++level)
    {
      folders.push_back(this->Folder + "/" + GetLevelPath(datasets, level));
    }
    LookForZarr(this->Files, folders, version);
  }

  /// What of an image is not read with it.
  void TellOthers(const Json& ome, int version)
  {
    if (FindJson(ome, "multiscales").size() > 1)
    {
      AddNote(this->Volume.LeftOut, "its first multiscales are read, and not the others");
    }
    const auto labels = ZarrNode::Read(this->Files, this->Folder + "/labels", version);
    const std::vector<std::string> names =
      labels.IsOk() ? ListPaths(FindJson(FindOme(*labels), "labels")) : std::vector<std::string>();
    if (!names.empty())
    {
      AddNote(
        this->Volume.LeftOut, "its labels are volumes of their own (labels/" + names.front() + ")");
    }
  }

  /// Opens an array as a level of the image around it, if there is one that names it.
  Status OpenLevel(const ZarrNode& node)
  {
    std::filesystem::path group = this->Folder;
    std::string within;
    for (int up = 0; up < 2 && group != "."; ++up)
    {
      within = group.filename().string() + (within.empty() ? "" : "/" + within);
      group = group.has_parent_path() ? group.parent_path() : ".";
      const auto outer = ZarrNode::Read(this->Files, group.string());
      if (!outer.IsOk() || outer->IsArray)
      {
        continue;
      }
      const Json& image = FindImage(FindOme(*outer));
      const Json& datasets = FindJson(image, "datasets");
      for (std::size_t level = 0; level < datasets.size(); ++level)
      {
        if (GetLevelPath(datasets, level) == within)
        {
          this->ArrayName = this->ArrayName.empty() ? this->MakeName() : this->ArrayName;
          this->Folder = group.string();
          this->Attributes = outer->Attributes;
          return this->OpenImage(image, FindJson(FindOme(*outer), "omero"), level, outer->Version);
        }
      }
    }
    return this->OpenArray(this->Folder, node, {}, {}, false);
  }

  /// The letters of an array's axes, the slowest first; likely ones if their names do not tell them.
  std::string FindArrayLetters(const ZarrNode& node, const ZarrMetadata& metadata)
  {
    std::vector<std::string> names = metadata.DimensionNames;
    if (metadata.IsN5)
    {
      names = ListPaths(FindJson(node.Attributes, "axes"));
      // N5 has the fastest one first; COSEM, which counts as NumPy does, the slowest one.
      if (!names.empty() && ArrayAxes::FindLetter(names.front()) == 'x')
      {
        std::reverse(names.begin(), names.end());
      }
    }
    std::string letters;
    std::transform(names.begin(), names.end(), std::back_inserter(letters), ArrayAxes::FindLetter);
    const bool isNamed = std::any_of(
      names.begin(), names.end(), [](const std::string& name) { return !name.empty(); });
    std::replace(names.begin(), names.end(), std::string(), std::string("?"));
    return ArrayAxes::Guess(
      metadata.Shape, letters, isNamed ? JoinTexts(names) : "", this->Volume.LeftOut);
  }

  /// The name of the array: that of the folder.
  std::string MakeName() const
  {
    std::string name = GetLastPart(this->Folder);
    if (name.size() > 5 && name.compare(name.size() - 5, 5, ".zarr") == 0)
    {
      name.resize(name.size() - 5);
    }
    return name;
  }

  Status OpenArray(const std::string& folder, const ZarrNode& node, const std::string& letters,
    const std::vector<std::string>& channels, bool isImage)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto metadata, ParseZarrMetadata(node, folder));
    FindChunks(this->Files, folder, metadata, this->Volume.LeftOut);
    std::string axisLetters = this->Choice.Axes.empty() ? letters : this->Choice.Axes;
    axisLetters = axisLetters.empty() ? this->FindArrayLetters(node, metadata) : axisLetters;
    const std::vector<std::string> names = metadata.DimensionNames;
    const auto axes = ArrayAxes::Parse(axisLetters, metadata.Shape.size());
    if (!axes.IsOk())
    {
      return this->MakeError(axes.GetStatus().GetCode(), folder, axes.GetStatus().GetMessage());
    }
    auto array = std::make_shared<ZarrArray>(
      this->Files, folder, std::move(metadata), this->Choice.CacheBytes);
    ISOSURFACE_ASSIGN_OR_RETURN(auto parts,
      MakeVolumeArrays(this->ArrayName.empty() ? this->MakeName() : this->ArrayName, array, *axes,
        this->Choice.Step, channels));
    ISOSURFACE_RETURN_IF_ERROR(
      TakeVolumeArrays(std::move(parts), this->Choice.Arrays, this->Volume));
    this->Axes = *axes;
    this->Volume.Files = this->FindFiles(folder, node.Version);
    this->Volume.Storage = node.Array.dump();
    this->Attributes.update(node.Attributes);
    if (!isImage)
    {
      this->TakeArrayPlace(folder, node, names);
    }
    return Status::Ok();
  }

  /// What tells whether the array was changed: of an address, which nobody can list, its metadata.
  std::vector<std::string> FindFiles(const std::string& folder, int version)
  {
    std::vector<std::string> paths =
      IsAddress(folder) ? ListMetadata(folder, version) : std::vector<std::string>();
    paths.erase(std::remove_if(paths.begin(), paths.end(),
                  [this](const std::string& path) { return !this->Files.Exists(path); }),
      paths.end());
    return paths.empty() ? std::vector<std::string>{ folder } : paths;
  }

  /// Tells the attributes of an array that nothing here is read from.
  void NoteAttributes(const Json& attributes)
  {
    const std::string used =
      " _ARRAY_DIMENSIONS axes blockSize compression compressionType dataType dimensions "
      "downsamplingFactors n5 offset pixelResolution resolution scales transform units voxel_size ";
    std::vector<std::string> unused;
    for (const auto& [name, value] : attributes.items())
    {
      const bool isList = value.is_array() && value.size() >= 3 && value.size() <= 5;
      const bool isBroken =
        !isList && (name == "resolution" || name == "voxel_size" || name == "offset");
      if (used.find(" " + name + " ") == std::string::npos || isBroken)
      {
        std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
        unused.push_back(name + (text.size() > 40 ? "" : " " + text));
      }
    }
    if (!unused.empty())
    {
      AddNote(this->Volume.LeftOut, "attributes that are not used: " + JoinTexts(unused));
    }
  }

  void TakeArrayPlace(
    const std::string& folder, const ZarrNode& node, const std::vector<std::string>& names)
  {
    GridGeometry& grid = this->Volume.Grid;
    const ZarrPlace place = FindZarrPlace(this->Files, folder, node, this->Axes);
    grid.Spacing = place.Spacing;
    grid.Origin = place.Origin;
    TakeLengthUnits(place.Units, grid, this->Volume.LeftOut);
    this->NoteAttributes(node.Attributes);
    if (!names.empty())
    {
      for (ArrayDescription& array : this->Volume.Arrays)
      {
        array.Unit = FindJsonText(node.Attributes, "units");
      }
      const auto of = [&names](int axis) { return names[static_cast<std::size_t>(axis)]; };
      TakeCoordinates(this->Files, folder, { of(this->Axes.X), of(this->Axes.Y), of(this->Axes.Z) },
        grid, this->Volume.LeftOut);
      if (this->Axes.Time >= 0)
      {
        TakeTimes(
          this->Files, folder, of(this->Axes.Time), this->Volume.Times, this->Volume.LeftOut);
      }
    }
  }

  Status OpenOnlyArray(int depth)
  {
    std::vector<FoundArray> arrays;
    ISOSURFACE_RETURN_IF_ERROR(FindArrays(this->Files, this->Folder, "", 0, arrays));
    std::vector<std::string> images;
    for (const FoundArray& array : arrays)
    {
      if (array.IsImage() && ("/" + array.Path).find("/labels/") == std::string::npos)
      {
        images.push_back(array.Path);
      }
    }
    if (images.size() == 1 && depth < MaximumZarrDepth)
    {
      this->Folder += "/" + images.front();
      return this->OpenFolder(depth + 1);
    }
    if (!images.empty())
    {
      return this->MakeError(StatusCode::NotFound, this->Name.GetText(),
        "name one of its images, as in " + this->Name.Path + ":path: " + JoinTexts(images));
    }
    arrays.erase(std::remove_if(arrays.begin(), arrays.end(),
                   [](const FoundArray& array) { return array.IsImage(); }),
      arrays.end());
    DropLevels(arrays);
    std::string known;
    for (std::size_t rank = 3; rank <= 5; ++rank)
    {
      std::vector<const FoundArray*> fitting;
      for (const FoundArray& array : arrays)
      {
        if (array.Fault.IsOk() && array.Metadata.Shape.size() == rank)
        {
          fitting.push_back(&array);
          known += (known.empty() ? "" : ", ") + array.Path + " (" +
            JoinNumbers(array.Metadata.Shape) + " " + GetValueTypeName(array.Metadata.Type) + ")";
        }
      }
      if (fitting.size() == 1)
      {
        const std::string folder = this->Folder + "/" + fitting[0]->Path;
        ISOSURFACE_ASSIGN_OR_RETURN(const auto node, ZarrNode::Read(this->Files, folder));
        const std::string last = GetLastPart(folder);
        this->ArrayName = last == "s0" ? this->MakeName() : last;
        return this->OpenArray(folder, node, {}, {}, false);
      }
      if (!fitting.empty())
      {
        break;
      }
    }
    if (known.empty() && !arrays.empty() && !arrays.front().Fault.IsOk())
    {
      return arrays.front().Fault;
    }
    return this->MakeError(StatusCode::NotFound, this->Name.GetText(),
      known.empty() ? "it has no array of numbers with 3 to 5 axes"
                    : "name one of its arrays, as in " + this->Name.Path + ":path: " + known);
  }

  /// The letters of the axes of multiscales, and their units; an object each since 0.4, and a text in 0.3.
  std::string FindLetters(const Json& axes)
  {
    std::string letters;
    for (const Json& axis : axes.is_array() ? axes : Json::array())
    {
      const std::string name = GetJsonText(axis.is_object() ? FindJson(axis, "name") : axis);
      const std::string type = GetJsonText(FindJson(axis, "type"));
      const std::string unit = GetJsonText(FindJson(axis, "unit"));
      letters += type == "time" ? 't' : type == "channel" ? 'c' : ArrayAxes::FindLetter(name);
      this->Units[letters.back()] = unit;
      if (letters.back() == 't' && !unit.empty() && unit != "second")
      {
        AddNote(this->Volume.LeftOut, "its time steps are in " + unit);
      }
    }
    return letters;
  }

  /// Adds scale and translation, in the order of the axes, to those before.
  Status AddTransformations(const Json& list, std::vector<double>& scale, std::vector<double>& move)
  {
    for (const Json& one : list.is_array() ? list : Json::array())
    {
      const std::string type = GetJsonText(FindJson(one, "type"));
      const Json& numbers = FindJson(one, type.c_str());
      if (type == "identity")
      {
        continue;
      }
      if ((type != "scale" && type != "translation") || !numbers.is_array() ||
        numbers.size() != scale.size() ||
        !std::all_of(numbers.begin(), numbers.end(), [](const Json& n) { return n.is_number(); }))
      {
        return this->MakeError(StatusCode::Unsupported, this->Folder,
          "its transformation, " + type +
            (FindJson(one, "path").is_null() ? "" : " in a file (path)") +
            ", is not a scale or a translation with a number an axis");
      }
      for (std::size_t axis = 0; axis < scale.size(); ++axis)
      {
        const double number = numbers[axis].is_number() ? numbers[axis].get<double>() : NAN;
        scale[axis] *= type == "scale" ? number : 1;
        move[axis] = type == "scale" ? move[axis] * number : move[axis] + number;
      }
    }
    return Status::Ok();
  }

  /// The level that is chosen (VolumeChoice::Vertices). One that cannot be read ends the search.
  std::size_t FindLevel(const Json& datasets, int version)
  {
    std::size_t level = 0;
    while (this->Choice.Vertices > 0)
    {
      const std::string path = GetLevelPath(datasets, level);
      const auto node = ZarrNode::Read(this->Files, this->Folder + "/" + path, version);
      const auto metadata = node.IsOk() && node->IsArray && !path.empty()
        ? ParseZarrMetadata(*node, this->Folder + "/" + path)
        : Result<ZarrMetadata>(Status(StatusCode::NotFound, path));
      if (!metadata.IsOk())
      {
        return level == 0 ? 0 : level - 1;
      }
      // Channels and times count, too: they make it a little coarser.
      const double samples = std::accumulate(metadata->Shape.begin(), metadata->Shape.end(), 1.0,
        [](double product, std::int64_t size) { return product * static_cast<double>(size); });
      if (samples <= static_cast<double>(this->Choice.Vertices))
      {
        return level;
      }
      ++level;
    }
    return level;
  }

  /// `chosen`: the number of a level that was named. N5 may have its axes the other way round.
  Status OpenImage(
    const Json& image, const Json& omero, std::optional<std::size_t> chosen, int version)
  {
    const Json& datasets = FindJson(image, "datasets");
    const std::size_t level = chosen ? *chosen : this->FindLevel(datasets, version);
    const std::string path = GetLevelPath(datasets, level);
    if (path.empty())
    {
      return this->MakeError(
        StatusCode::Corrupt, this->Folder, "its multiscales have no datasets with a path");
    }
    this->Volume.Level = chosen ? 0 : static_cast<int>(level);
    std::vector<std::string> channels;
    const Json& known = FindJson(omero, "channels");
    const Json& axes = FindJson(image, "axes");
    if (axes.size() > MaximumAxes || known.size() > MaximumChannels)
    {
      return this->MakeError(StatusCode::Unsupported, this->Folder,
        "its multiscales have " + std::to_string(axes.size()) + " axes and " +
          std::to_string(known.size()) + " channels");
    }
    for (const Json& channel : known.is_array() ? known : Json::array())
    {
      const std::string label = GetJsonText(FindJson(channel, "label"));
      const bool isNew = std::find(channels.begin(), channels.end(), label) == channels.end();
      channels.push_back(
        !label.empty() && isNew ? label : "channel " + std::to_string(channels.size()));
    }
    const Json& transform = FindJson(datasets[level], "transform");
    std::string letters = this->FindLetters(axes.is_null() ? FindJson(transform, "axes") : axes);
    if (version == 5 && !letters.empty() && letters.front() == 'x')
    {
      std::reverse(letters.begin(), letters.end());
    }
    const std::string folder = this->Folder + "/" + path;
    ISOSURFACE_ASSIGN_OR_RETURN(const auto node, ZarrNode::Read(this->Files, folder, version));
    if (!node.IsArray)
    {
      return this->MakeError(StatusCode::Corrupt, folder, "there is no array");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->OpenArray(folder, node, letters, channels, true));
    if (ZarrPlace place; TakeTransform(transform, place))
    {
      this->Volume.Grid.Spacing = place.Spacing;
      this->Volume.Grid.Origin = place.Origin;
      TakeLengthUnits(place.Units, this->Volume.Grid, this->Volume.LeftOut);
      return Status::Ok();
    }
    return this->TakePlace(image, datasets[level]);
  }

  Status TakePlace(const Json& image, const Json& dataset)
  {
    std::size_t rank = 3;
    rank += this->Axes.Time >= 0 ? 1 : 0;
    rank += this->Axes.Channel >= 0 ? 1 : 0;
    std::vector<double> scale(rank, 1);
    std::vector<double> move(rank, 0);
    ISOSURFACE_RETURN_IF_ERROR(
      this->AddTransformations(FindJson(dataset, "coordinateTransformations"), scale, move));
    ISOSURFACE_RETURN_IF_ERROR(
      this->AddTransformations(FindJson(image, "coordinateTransformations"), scale, move));
    const std::array<int, 3> axes = { this->Axes.X, this->Axes.Y, this->Axes.Z };
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Volume.Grid.Spacing[axis] = scale[static_cast<std::size_t>(axes[axis])];
      this->Volume.Grid.Origin[axis] = move[static_cast<std::size_t>(axes[axis])];
    }
    TakeLengthUnits({ this->Units['x'], this->Units['y'], this->Units['z'] }, this->Volume.Grid,
      this->Volume.LeftOut);
    if (this->Axes.Time >= 0)
    {
      const auto axis = static_cast<std::size_t>(this->Axes.Time);
      for (double& time : this->Volume.Times)
      {
        time = time * scale[axis] + move[axis];
      }
    }
    return Status::Ok();
  }

  FileSystem& Files;
  const VolumeName& Name;
  const VolumeChoice& Choice;
  std::string Folder;
  std::string ArrayName;
  ArrayAxes Axes;
  Json Attributes = Json::object();  ///< of the group of an image, and of the array
  std::map<char, std::string> Units; ///< of the axes of multiscales, by their letters
  OpenedVolume Volume;
};

} // namespace

Result<OpenedVolume> OpenZarrVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  return ZarrReader(files, name, choice).Open();
}

bool IsZarrMetadata(const std::string& name)
{
  return std::any_of(std::begin(MetadataNames), std::end(MetadataNames),
    [&name](const auto& known) { return name == known.first; });
}

void LookForZarr(FileSystem& files, const std::vector<std::string>& folders, int version)
{
  std::vector<std::string> paths;
  for (const std::string& folder : folders)
  {
    const std::vector<std::string> names = ListMetadata(folder, version);
    paths.insert(paths.end(), names.begin(), names.end());
  }
  files.LookFor(paths);
}

bool IsZarrFolder(FileSystem& files, const std::string& path)
{
  LookForZarr(files, { path });
  const std::vector<std::string> paths = ListMetadata(path, 0);
  return std::any_of(
    paths.begin(), paths.end(), [&](const std::string& one) { return files.Exists(one); });
}

} // namespace isosurface
