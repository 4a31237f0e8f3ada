// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrVolume.h"

#include "Formats/Source/ArraySource.h"
#include "Formats/Zarr/JsonField.h"
#include "Formats/Zarr/ZarrArray.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

namespace isosurface
{
namespace
{

using Json = nlohmann::json;

constexpr const char* MetadataNames[] = { "zarr.json", ".zarray", ".zgroup", ".zattrs",
  "attributes.json" };
constexpr int MaximumDepth = 8;
constexpr std::size_t MaximumArrays = 10000;
/// Of an image; each is compared with those before.
constexpr std::size_t MaximumAxes = 32;
constexpr std::size_t MaximumChannels = 1024;

std::string GetLastPart(const std::string& path)
{
  const std::size_t end = path.find_last_not_of('/');
  const std::string whole = path.substr(0, end == std::string::npos ? 0 : end + 1);
  return whole.substr(whole.rfind('/') + 1);
}

/// An array in a hierarchy.
struct FoundArray
{
  std::string Path; ///< below the folder
  ZarrMetadata Metadata;
  Status Fault; ///< why it cannot be read
};

/// Adds the arrays in a folder, by name.
Status FindArrays(FileSystem& files, const std::string& folder, const std::string& path, int depth,
  std::vector<FoundArray>& arrays)
{
  const std::string whole = path.empty() ? folder : folder + "/" + path;
  const auto node = ZarrNode::Read(files, whole);
  if (node.GetStatus().GetCode() == StatusCode::Corrupt && depth > 0)
  {
    // Others can be read.
    arrays.push_back({ path, ZarrMetadata(), node.GetStatus() });
    return Status::Ok();
  }
  ISOSURFACE_RETURN_IF_ERROR(node.GetStatus());
  if (node->IsArray)
  {
    auto metadata = ParseZarrMetadata(*node, whole);
    arrays.push_back(
      { path, metadata.IsOk() ? std::move(*metadata) : ZarrMetadata(), metadata.GetStatus() });
    return Status::Ok();
  }
  const auto names = files.List(whole);
  if (depth >= MaximumDepth || !names.IsOk())
  {
    return Status::Ok();
  }
  const std::string prefix = path.empty() ? path : path + "/";
  const std::string wholePrefix = whole + "/";
  for (const std::string& name : *names)
  {
    const auto inner = files.List(wholePrefix + name);
    if (name[0] != '.' && inner.IsOk() && !inner->empty() && arrays.size() < MaximumArrays)
    {
      ISOSURFACE_RETURN_IF_ERROR(FindArrays(files, folder, prefix + name, depth + 1, arrays));
    }
  }
  return Status::Ok();
}

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
    const auto node = ZarrNode::Read(this->Files, this->Folder);
    ISOSURFACE_RETURN_IF_ERROR(node.GetStatus());
    this->Volume.Grid.Extent = {};
    if (node->IsArray)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->OpenArray(this->Folder, *node, {}, {}));
      return std::move(this->Volume);
    }
    const Json& ome = FindJson(node->Attributes, "ome");
    const Json& attributes = ome.is_object() ? ome : node->Attributes;
    const Json& multiscales = FindJson(attributes, "multiscales");
    if (multiscales.is_array() && !multiscales.empty())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->OpenImage(multiscales[0], FindJson(attributes, "omero")));
      return std::move(this->Volume);
    }
    ISOSURFACE_RETURN_IF_ERROR(this->OpenOnlyArray());
    return std::move(this->Volume);
  }

private:
  Status MakeError(StatusCode code, const std::string& folder, const std::string& reason) const
  {
    return Status(code, folder + ": cannot be read: " + reason);
  }

  Status OpenArray(const std::string& folder, const ZarrNode& node, const std::string& letters,
    const std::vector<std::string>& channels)
  {
    auto metadata = ParseZarrMetadata(node, folder);
    ISOSURFACE_RETURN_IF_ERROR(metadata.GetStatus());
    std::string axisLetters = this->Choice.Axes.empty() ? letters : this->Choice.Axes;
    if (axisLetters.empty())
    {
      for (const std::string& name : metadata->DimensionNames)
      {
        axisLetters += name.size() == 1 ? name : name == "time" ? "t" : "?";
      }
      axisLetters =
        axisLetters.find_first_not_of("tczyx") == std::string::npos ? axisLetters : std::string();
    }
    const auto axes = ArrayAxes::Parse(axisLetters, metadata->Shape);
    if (!axes.IsOk())
    {
      return this->MakeError(axes.GetStatus().GetCode(), folder, axes.GetStatus().GetMessage());
    }
    auto array = std::make_shared<ZarrArray>(
      this->Files, folder, std::move(*metadata), this->Choice.CacheBytes);
    std::string name = GetLastPart(this->Folder);
    if (name.size() > 5 && name.compare(name.size() - 5, 5, ".zarr") == 0)
    {
      name.resize(name.size() - 5);
    }
    auto parts = MakeParts(
      this->ArrayName.empty() ? name : this->ArrayName, array, *axes, this->Choice.Step, channels);
    ISOSURFACE_RETURN_IF_ERROR(parts.GetStatus());
    ISOSURFACE_RETURN_IF_ERROR(TakeParts(std::move(*parts), this->Choice.Arrays, this->Volume));
    this->Axes = *axes;
    this->Volume.Files = { folder };
    this->Volume.Storage = node.Array.dump();
    return Status::Ok();
  }

  Status OpenOnlyArray()
  {
    std::vector<FoundArray> arrays;
    ISOSURFACE_RETURN_IF_ERROR(FindArrays(this->Files, this->Folder, "", 0, arrays));
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
        const auto node = ZarrNode::Read(this->Files, folder);
        ISOSURFACE_RETURN_IF_ERROR(node.GetStatus());
        this->ArrayName = GetLastPart(folder);
        return this->OpenArray(folder, *node, {}, {});
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

  /// The letters of the axes of multiscales; an object each since 0.4, and a text in 0.3.
  std::string FindLetters(const Json& axes)
  {
    std::string letters;
    for (const Json& axis : axes.is_array() ? axes : Json::array())
    {
      const std::string name = GetJsonText(axis.is_object() ? FindJson(axis, "name") : axis);
      const std::string type = GetJsonText(FindJson(axis, "type"));
      const std::string unit = GetJsonText(FindJson(axis, "unit"));
      letters += type == "time" ? "t" : type == "channel" ? "c" : name.size() == 1 ? name : "?";
      if (!unit.empty() && this->Volume.LeftOut.find(unit) == std::string::npos)
      {
        this->Volume.LeftOut +=
          (this->Volume.LeftOut.empty() ? "units of the axes are not kept: " : ", ") + unit;
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
        numbers.size() != scale.size())
      {
        return this->MakeError(StatusCode::Unsupported, this->Folder,
          "its transformation, " + type +
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

  /// The path of a level, the finest one first; empty if there is none.
  static std::string GetLevelPath(const Json& datasets, std::size_t level)
  {
    const std::string path = datasets.is_array() && level < datasets.size()
      ? GetJsonText(FindJson(datasets[level], "path"))
      : std::string();
    return path.find("..") == std::string::npos ? path : std::string();
  }

  /// The level that is chosen (VolumeChoice::Vertices). One that cannot be read ends the search.
  std::size_t FindLevel(const Json& datasets)
  {
    std::size_t level = 0;
    while (this->Choice.Vertices > 0)
    {
      const std::string path = GetLevelPath(datasets, level);
      const auto node = ZarrNode::Read(this->Files, this->Folder + "/" + path);
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

  Status OpenImage(const Json& image, const Json& omero)
  {
    const Json& datasets = FindJson(image, "datasets");
    const std::size_t level = this->FindLevel(datasets);
    const std::string path = GetLevelPath(datasets, level);
    if (path.empty())
    {
      return this->MakeError(
        StatusCode::Corrupt, this->Folder, "its multiscales have no datasets with a path");
    }
    this->Volume.Level = static_cast<int>(level);
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
    const std::string letters = this->FindLetters(axes);
    const std::string folder = this->Folder + "/" + path;
    const auto node = ZarrNode::Read(this->Files, folder);
    ISOSURFACE_RETURN_IF_ERROR(node.GetStatus());
    if (!node->IsArray)
    {
      return this->MakeError(StatusCode::Corrupt, folder, "there is no array");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->OpenArray(folder, *node, letters, channels));
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
  OpenedVolume Volume;
};

} // namespace

Result<OpenedVolume> OpenZarrVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  return ZarrReader(files, name, choice).Open();
}

Result<std::vector<VolumeListing>> ListZarr(FileSystem& files, const VolumeName& name)
{
  std::vector<FoundArray> arrays;
  const std::string folder = name.Within.empty() ? name.Path : name.Path + "/" + name.Within;
  ISOSURFACE_RETURN_IF_ERROR(FindArrays(files, folder, "", 0, arrays));
  std::vector<VolumeListing> list;
  for (const FoundArray& array : arrays)
  {
    const bool isOk = array.Fault.IsOk();
    list.push_back(
      { array.Path.empty() ? "." : array.Path, isOk ? JoinNumbers(array.Metadata.Shape) : "?",
        isOk && array.Metadata.IsHalf ? "float16"
          : isOk                      ? GetValueTypeName(array.Metadata.Type)
                                      : "?",
        isOk ? array.Metadata.Storage : array.Fault.GetMessage() });
  }
  return list;
}

bool IsZarrMetadata(const std::string& name)
{
  return std::find(std::begin(MetadataNames), std::end(MetadataNames), name) !=
    std::end(MetadataNames);
}

bool IsZarrFolder(FileSystem& files, const std::string& path)
{
  return std::any_of(std::begin(MetadataNames), std::end(MetadataNames),
    [&](const char* name) { return files.Exists(path + "/" + name); });
}

} // namespace isosurface
