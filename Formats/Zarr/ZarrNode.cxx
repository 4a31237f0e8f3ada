// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/JsonField.h"
#include "Formats/Zarr/ZarrMetadata.h"
#include "Formats/Zarr/ZarrVolume.h"
#include "Ground/Base/JsonDepth.h"

#include <utility>

namespace isosurface
{
namespace
{

using Json = nlohmann::json;

constexpr std::uint64_t MaximumJsonSize = std::uint64_t{ 16 } << 20;
/// Attributes are the user's, and may have any depth that somebody writes by hand.
constexpr int MaximumNesting = 64;

/// JSON in which the numbers that it does not have are texts. Python writes them bare in attributes.
std::string QuoteBareNumbers(const std::string& text)
{
  std::string quoted;
  quoted.reserve(text.size());
  bool isText = false;
  for (std::size_t at = 0; at < text.size(); ++at)
  {
    std::string token(1, text[at]);
    if (isText && text[at] == '\\')
    {
      token = text.substr(at, 2);
    }
    else if (text[at] == '"')
    {
      isText = !isText;
    }
    for (const char* const number : { "NaN", "Infinity", "-Infinity" })
    {
      const std::size_t size = std::char_traits<char>::length(number);
      if (!isText && text.compare(at, size, number) == 0)
      {
        token = number;
      }
    }
    at += token.size() - 1;
    quoted += token.size() > 2 ? '"' + token + '"' : token;
  }
  return quoted;
}

/// The JSON of a file; null if there is no such file.
Result<Json> ReadJson(FileSystem& files, const std::string& path)
{
  if (!files.Exists(path))
  {
    return Json();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  if (file->GetSize() > MaximumJsonSize)
  {
    return Status(StatusCode::Corrupt, path + ": cannot be read: it is too large for metadata");
  }
  std::string text(static_cast<std::size_t>(file->GetSize()), '\0');
  ISOSURFACE_RETURN_IF_ERROR(file->Read(0, text.size(), text.data()));
  if (IsJsonDeeperThan(text, MaximumNesting))
  {
    return Status(StatusCode::Corrupt,
      path + ": cannot be read: it nests more than " + std::to_string(MaximumNesting) + " objects");
  }
  // NaN and infinity stand between quotation marks in both versions, but not in all files.
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded())
  {
    json = Json::parse(QuoteBareNumbers(text), nullptr, false);
  }
  if (!json.is_object())
  {
    return Status(StatusCode::Corrupt, path + ": cannot be read: it is no JSON object; truncated?");
  }
  return json;
}

} // namespace

Result<ZarrNode> ZarrNode::Read(FileSystem& files, const std::string& folder, int around)
{
  const int version = IsAddress(folder) ? around : 0;
  const auto read = [&](int of, const char* name)
  { return version == 0 || version == of ? ReadJson(files, folder + name) : Result<Json>(Json()); };
  ZarrNode node;
  node.Attributes = Json::object();
  LookForZarr(files, { folder }, version);
  ISOSURFACE_ASSIGN_OR_RETURN(auto third, read(3, "/zarr.json"));
  if (third.is_object())
  {
    node.Version = 3;
    node.IsArray = FindJsonText(third, "node_type") == "array";
    if (FindJson(third, "attributes").is_object())
    {
      node.Attributes = FindJson(third, "attributes");
    }
    node.Array = std::move(third);
    return node;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto array, read(2, "/.zarray"));
  ISOSURFACE_ASSIGN_OR_RETURN(auto attributes, read(2, "/.zattrs"));
  if (array.is_object() || attributes.is_object() ||
    (version == 0 && files.Exists(folder + "/.zgroup")))
  {
    node.Version = 2;
    node.IsArray = array.is_object();
    node.Array = std::move(array);
    node.Attributes = attributes.is_object() ? std::move(attributes) : node.Attributes;
    return node;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto n5, read(5, "/attributes.json"));
  if (n5.is_object())
  {
    node.Version = 5;
    node.IsArray = n5.contains("dimensions") && n5.contains("blockSize");
    node.Array = n5;
    node.Attributes = std::move(n5);
  }
  return node;
}

} // namespace isosurface
