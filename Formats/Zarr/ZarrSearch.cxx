// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrSearch.h"

#include "Formats/Zarr/JsonField.h"
#include "Formats/Zarr/ZarrVolume.h"

#include <algorithm>
#include <set>
#include <utility>

namespace isosurface
{
namespace
{

using Json = nlohmann::json;

/// The multiscales of a folder, as they are listed.
FoundArray DescribeImage(
  FileSystem& files, const std::string& whole, const std::string& path, const Json& image)
{
  const Json& datasets = FindJson(image, "datasets");
  const std::string finest = whole + "/" + GetLevelPath(datasets, 0);
  const auto node = ZarrNode::Read(files, finest);
  auto metadata = node.IsOk() && node->IsArray
    ? ParseZarrMetadata(*node, finest)
    : Result<ZarrMetadata>(Status(StatusCode::Corrupt, finest + ": there is no array"));
  return { path, metadata.IsOk() ? std::move(*metadata) : ZarrMetadata(), metadata.GetStatus(),
    std::max<std::size_t>(1, datasets.size()) };
}

} // namespace

std::string GetLastPart(const std::string& path)
{
  const std::size_t end = path.find_last_not_of('/');
  const std::string whole = path.substr(0, end == std::string::npos ? 0 : end + 1);
  return whole.substr(whole.rfind('/') + 1);
}

const Json& FindOme(const ZarrNode& node)
{
  const Json& ome = FindJson(node.Attributes, "ome");
  return ome.is_object() ? ome : node.Attributes;
}

const Json& FindImage(const Json& ome)
{
  static const Json nothing;
  const Json& multiscales = FindJson(ome, "multiscales");
  return multiscales.is_array() && !multiscales.empty() ? multiscales[0] : nothing;
}

std::string GetLevelPath(const Json& datasets, std::size_t level)
{
  const std::string path = datasets.is_array() && level < datasets.size()
    ? GetJsonText(FindJson(datasets[level], "path"))
    : std::string();
  return path.find("..") == std::string::npos ? path : std::string();
}

std::vector<std::string> ListPaths(const Json& list, const char* member)
{
  std::vector<std::string> paths;
  for (const Json& one : list.is_array() ? list : Json::array())
  {
    const std::string path = GetJsonText(member ? FindJson(one, member) : one);
    if (!path.empty() && path.find("..") == std::string::npos)
    {
      paths.push_back(path);
    }
  }
  return paths;
}

std::string JoinTexts(const std::vector<std::string>& texts)
{
  constexpr std::size_t most = 100;
  std::string joined;
  for (std::size_t n = 0; n < std::min(most, texts.size()); ++n)
  {
    joined += (joined.empty() ? "" : ", ") + texts[n];
  }
  return joined + (texts.size() > most ? ", ..." : "");
}

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
  if (const Json& image = FindImage(FindOme(*node)); !image.is_null() && !path.empty())
  {
    arrays.push_back(DescribeImage(files, whole, path, image));
  }
  const auto names = files.List(whole);
  if (depth >= MaximumZarrDepth || !names.IsOk())
  {
    return Status::Ok();
  }
  const std::string prefix = path.empty() ? path : path + "/";
  const std::string wholePrefix = whole + "/";
  for (const std::string& name : *names)
  {
    const auto inner = files.List(wholePrefix + name);
    if (name[0] != '.' && inner.IsOk() && !inner->empty() && arrays.size() < MaximumZarrArrays)
    {
      ISOSURFACE_RETURN_IF_ERROR(FindArrays(files, folder, prefix + name, depth + 1, arrays));
    }
  }
  return Status::Ok();
}

void DropLevels(std::vector<FoundArray>& arrays)
{
  std::set<std::string> pyramids;
  const auto findGroup = [](const std::string& path)
  { return path.substr(0, path.size() - GetLastPart(path).size()); };
  for (const FoundArray& array : arrays)
  {
    if (GetLastPart(array.Path) == "s0" && array.Fault.IsOk())
    {
      pyramids.insert(findGroup(array.Path));
    }
  }
  const auto isCoarse = [&](const FoundArray& array)
  {
    const std::string last = GetLastPart(array.Path);
    return last.size() > 1 && last[0] == 's' && last != "s0" &&
      last.find_first_not_of("0123456789", 1) == std::string::npos &&
      pyramids.count(findGroup(array.Path)) > 0;
  };
  arrays.erase(std::remove_if(arrays.begin(), arrays.end(), isCoarse), arrays.end());
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
        !isOk               ? array.Fault.GetMessage()
          : array.IsImage() ? "an image of " + std::to_string(array.Levels) + " levels"
                            : array.Metadata.Storage });
  }
  return list;
}

} // namespace isosurface
