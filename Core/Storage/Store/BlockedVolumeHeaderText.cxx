// SPDX-License-Identifier: BSD-3-Clause
// The text of a header: BlockedVolumeHeader::Format(), Parse() and Read().
#include "Storage/Record/BlockCompression.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/JsonDocument.h"
#include "Storage/Store/SourceRecordText.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* FormatName = "ScalableIsosurface blocked volume";
constexpr std::int64_t MaximumCoordinate = BlockedVolumeHeader::MaximumCoordinate;
constexpr std::int64_t MaximumStores = BlockedVolumeHeader::MaximumStores;

template <std::size_t Size>
void ReadNumbers(JsonMembers& members, const char* name, std::array<double, Size>& numbers)
{
  const Json& array = members.GetArray(name, Size);
  for (std::size_t index = 0; index < array.size(); ++index)
  {
    if (!array[index].is_number())
    {
      members.Fail(name, "is not an array of numbers");
      return;
    }
    numbers[index] = array[index].get<double>();
  }
}

GridGeometry ReadGrid(JsonMembers& document, const std::string& path, Status& status)
{
  JsonMembers members(document.GetAny("grid"), path, "grid.", status);
  GridGeometry grid;
  const Json& extent = members.GetArray("extent", 6);
  for (std::size_t index = 0; index < extent.size(); ++index)
  {
    const Json& coordinate = extent[index];
    const bool isTooLarge = coordinate.is_number_unsigned() &&
      coordinate.get<std::uint64_t>() > static_cast<std::uint64_t>(MaximumCoordinate);
    if (!coordinate.is_number_integer() || isTooLarge)
    {
      members.Fail("extent", "is not an array of integers up to 2^40");
      return grid;
    }
    grid.Extent[index] = coordinate.get<std::int64_t>();
  }
  ReadNumbers(members, "origin", grid.Origin);
  ReadNumbers(members, "spacing", grid.Spacing);
  ReadNumbers(members, "direction", grid.Direction);
  return grid;
}

/// The coordinates of a rectilinear grid, which has three lists of numbers; nothing of another
/// grid.
std::optional<GridLines> ReadLines(JsonMembers& document, const std::string& path, Status& status)
{
  const Json& grid = document.GetAny("grid");
  if (!grid.is_object() || !grid.contains("coordinates"))
  {
    return std::nullopt;
  }
  JsonMembers members(grid, path, "grid.", status);
  const Json& axes = members.GetArray("coordinates", 3);
  GridLines lines;
  for (std::size_t axis = 0; axis < axes.size(); ++axis)
  {
    const Json& list = axes[axis];
    if (!list.is_array() ||
      !std::all_of(list.begin(), list.end(), [](const Json& line) { return line.is_number(); }))
    {
      members.Fail("coordinates", "is not three arrays of numbers");
      return std::nullopt;
    }
    lines.Coordinates[axis] = list.get<std::vector<double>>();
  }
  return lines;
}

void ReadBlocks(JsonMembers& members, BlockedVolumeHeader& header)
{
  header.BlockSize = static_cast<int>(members.GetInteger("blockSize", 16, 64));
  if (!IsBlockSize(header.BlockSize))
  {
    members.Fail("blockSize", "is not 16, 32 or 64");
  }
  members.GetInteger("ghostLayers", 1, 1);
  header.NumberOfLevels = static_cast<int>(
    members.GetInteger("numberOfLevels", 1, GetMaximumNumberOfLevels(header.BlockSize)));
  header.NumberOfStores =
    static_cast<std::uint32_t>(members.GetInteger("stores", 1, MaximumStores));
  if (members.Has("replicas"))
  {
    header.NumberOfReplicas = static_cast<std::uint32_t>(
      members.GetInteger("replicas", 1, BlockedVolumeHeader::MaximumReplicas));
  }
}

void ReadDistribution(
  JsonMembers& document, const std::string& path, Status& status, BlockedVolumeHeader& header)
{
  JsonMembers members(document.GetAny("distribution"), path, "distribution.", status);
  const auto method = FindDistribution(members.GetString("method"));
  if (!method)
  {
    members.Fail("method", "is not known");
  }
  header.Distribution = method.value_or(DistributionMethod::Greedy);
  header.RandomSeed = members.GetUnsigned("seed");
}

/// The key of a number that the type can hold exactly.
template <typename T>
std::optional<ValueKey> ReadKey(const Json& number)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    if (!number.is_number())
    {
      return std::nullopt;
    }
    const double value = number.get<double>();
    // Compared before the conversion, which is undefined for doubles that a float cannot hold.
    if (!std::isfinite(value) ||
      std::abs(value) > static_cast<double>(std::numeric_limits<T>::max()))
    {
      return std::nullopt;
    }
    return MakeValueKey(static_cast<T>(value));
  }
  else
  {
    if (!number.is_number_integer())
    {
      return std::nullopt;
    }
    if (number.is_number_unsigned())
    {
      const auto value = number.get<std::uint64_t>();
      return value > static_cast<std::uint64_t>(std::numeric_limits<T>::max())
        ? std::nullopt
        : std::optional<ValueKey>(MakeValueKey(static_cast<T>(value)));
    }
    const auto value = number.get<std::int64_t>(); // negative
    return std::is_unsigned_v<T> || value < static_cast<std::int64_t>(std::numeric_limits<T>::min())
      ? std::nullopt
      : std::optional<ValueKey>(MakeValueKey(static_cast<T>(value)));
  }
}

KeyRange ReadRange(JsonMembers& members, const Json& json, ValueType type)
{
  if (json.is_null())
  {
    return {};
  }
  std::optional<ValueKey> minimum;
  std::optional<ValueKey> maximum;
  if (json.is_array() && json.size() == 2)
  {
    DispatchValueType(type,
      [&](auto zero)
      {
        minimum = ReadKey<decltype(zero)>(json[0]);
        maximum = ReadKey<decltype(zero)>(json[1]);
      });
  }
  if (!minimum || !maximum || *minimum > *maximum)
  {
    members.Fail("ranges", "is not an array of ranges of values of the arrays");
    return {};
  }
  return { *minimum, *maximum };
}

std::vector<ArrayDescription> ReadArrays(JsonMembers& document, Status& status)
{
  std::vector<ArrayDescription> arrays;
  // All together: what is made of them has an entry for each component.
  std::int64_t left = BlockDirectory::MaximumSegments;
  const Json& list = document.GetArray("arrays", JsonMembers::AnySize);
  for (std::size_t index = 0; index < list.size() && status.IsOk(); ++index)
  {
    JsonMembers members = document.GetElement("arrays", list, index);
    ArrayDescription array;
    array.Name = members.GetString("name");
    const std::string typeName = members.GetString("type");
    const auto type = FindValueType(typeName);
    if (!type)
    {
      members.Fail("type", "\"" + typeName + "\" is not known");
    }
    array.Type = type.value_or(ValueType::UInt8);
    array.Components = static_cast<int>(members.GetInteger("components", 1, left));
    left -= array.Components;
    arrays.push_back(array);
  }
  return arrays;
}

std::vector<StoreDescription> ReadStores(
  JsonMembers& members, std::uint32_t count, const Status& status)
{
  std::vector<StoreDescription> stores;
  const Json& list = members.GetArray("stores", count);
  for (std::size_t index = 0; index < list.size() && status.IsOk(); ++index)
  {
    JsonMembers store = members.GetElement("stores", list, index);
    stores.push_back(
      { store.GetUnsigned("blocks"), store.GetUnsigned("bytes"), store.GetChecksum("checksum") });
  }
  return stores;
}

std::vector<OverviewDescription> ReadOverviews(
  JsonMembers& document, int largestNumberOfLevels, const Status& status)
{
  std::vector<OverviewDescription> overviews;
  const Json& list = document.GetArray("overviews", JsonMembers::AnySize);
  for (std::size_t index = 0; index < list.size() && status.IsOk(); ++index)
  {
    JsonMembers members = document.GetElement("overviews", list, index);
    OverviewDescription overview;
    overview.NumberOfLevels =
      static_cast<int>(members.GetInteger("numberOfLevels", 1, largestNumberOfLevels));
    overview.NumberOfStores =
      static_cast<std::uint32_t>(members.GetInteger("stores", 1, MaximumStores));
    overviews.push_back(overview);
  }
  return overviews;
}

TimeStepDescription ReadTimeStep(
  JsonMembers& members, const BlockedVolumeHeader& header, Status& status)
{
  TimeStepDescription step;
  if (!members.GetAny("time").is_null())
  {
    step.Time = members.GetNumber("time");
  }
  step.Folder = members.GetString("folder");
  const ArrayVariables variables = header.GetVariables();
  const Json& ranges = members.GetArray("ranges", variables.GetCount());
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    step.Ranges.push_back(ReadRange(members, ranges[variable], variables[variable].Type));
  }
  step.Stores = ReadStores(members, header.NumberOfStores, status);
  const Json& overviews = members.GetArray("overviews", header.Overviews.size());
  for (std::size_t index = 0; index < overviews.size() && status.IsOk(); ++index)
  {
    JsonMembers overview = members.GetElement("overviews", overviews, index);
    step.Overviews.push_back(ReadStores(overview, header.Overviews[index].NumberOfStores, status));
  }
  if (members.Has("source"))
  {
    JsonMembers source = members.GetObject("source");
    step.Source = ReadSource(source);
  }
  return step;
}

Json FormatRange(ValueType type, const KeyRange& range)
{
  if (range.IsEmpty())
  {
    return nullptr;
  }
  return DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      return Json::array({ MakeValueOfKey<T>(range.Minimum), MakeValueOfKey<T>(range.Maximum) });
    });
}

Json FormatStores(const std::vector<StoreDescription>& stores)
{
  Json json = Json::array();
  for (const StoreDescription& store : stores)
  {
    json.push_back({ { "blocks", store.Blocks }, { "bytes", store.Bytes },
      { "checksum", FormatChecksum(store.Checksum) } });
  }
  return json;
}

Json FormatTimeStep(const TimeStepDescription& step, const ArrayVariables& variables)
{
  Json json = { { "time", step.Time ? Json(*step.Time) : Json() }, { "folder", step.Folder },
    { "ranges", Json::array() }, { "stores", FormatStores(step.Stores) },
    { "overviews", Json::array() } };
  for (std::size_t variable = 0; variable < step.Ranges.size(); ++variable)
  {
    json["ranges"].push_back(FormatRange(variables[variable].Type, step.Ranges[variable]));
  }
  for (const std::vector<StoreDescription>& stores : step.Overviews)
  {
    json["overviews"].push_back({ { "stores", FormatStores(stores) } });
  }
  if (step.Source)
  {
    json["source"] = FormatSource(*step.Source);
  }
  return json;
}

} // namespace

std::string BlockedVolumeHeader::Format() const
{
  Json document;
  document["format"] = FormatName;
  document["formatVersion"] = FormatVersion;
  document["grid"] = { { "extent", this->Grid.Extent }, { "origin", this->Grid.Origin },
    { "spacing", this->Grid.Spacing }, { "direction", this->Grid.Direction } };
  if (this->Lines)
  {
    document["grid"]["coordinates"] = this->Lines->Coordinates;
  }
  document["blockSize"] = this->BlockSize;
  document["ghostLayers"] = 1;
  document["numberOfLevels"] = this->GetBlockGrid().GetNumberOfLevels();
  document["stores"] = this->NumberOfStores;
  if (this->NumberOfReplicas > 1)
  {
    document["replicas"] = this->NumberOfReplicas;
  }
  document["distribution"] = { { "method", GetDistributionName(this->Distribution) },
    { "seed", this->RandomSeed } };
  document["compression"] = GetCodecName(this->Compression.Codec);
  if (this->Compression.Codec != SegmentCodec::None)
  {
    document["compressionLevel"] = this->Compression.GetEffectiveLevel();
  }
  document["arrays"] = Json::array();
  for (const ArrayDescription& array : this->Arrays)
  {
    document["arrays"].push_back({ { "name", array.Name }, { "type", GetValueTypeName(array.Type) },
      { "components", array.Components } });
  }
  document["overviews"] = Json::array();
  for (const OverviewDescription& overview : this->Overviews)
  {
    document["overviews"].push_back(
      { { "numberOfLevels", overview.NumberOfLevels }, { "stores", overview.NumberOfStores } });
  }
  const ArrayVariables variables = this->GetVariables();
  document["timeSteps"] = Json::array();
  for (const TimeStepDescription& step : this->TimeSteps)
  {
    document["timeSteps"].push_back(FormatTimeStep(step, variables));
  }
  return FormatDocument(std::move(document));
}

Result<BlockedVolumeHeader> BlockedVolumeHeader::Parse(
  const std::string& text, const std::string& path)
{
  const auto document = ParseDocument(text, path, FormatName, FormatVersion);
  ISOSURFACE_RETURN_IF_ERROR(document.GetStatus());
  Status status;
  JsonMembers members(*document, path, "", status);
  BlockedVolumeHeader header;
  header.Grid = ReadGrid(members, path, status);
  header.Lines = ReadLines(members, path, status);
  ReadBlocks(members, header);
  ReadDistribution(members, path, status, header);
  const std::string compression = members.GetString("compression");
  const auto codec = FindCodec(compression);
  header.Compression.Codec = codec.value_or(SegmentCodec::None);
  if (header.Compression.Codec != SegmentCodec::None)
  {
    header.Compression.Level = static_cast<int>(members.GetInteger("compressionLevel", 1, 99));
  }
  header.Arrays = ReadArrays(members, status);
  header.Overviews = ReadOverviews(members, GetMaximumNumberOfLevels(header.BlockSize), status);
  const Json& steps = members.GetArray("timeSteps", JsonMembers::AnySize);
  for (std::size_t index = 0; index < steps.size() && status.IsOk(); ++index)
  {
    JsonMembers step = members.GetElement("timeSteps", steps, index);
    header.TimeSteps.push_back(ReadTimeStep(step, header, status));
  }
  ISOSURFACE_RETURN_IF_ERROR(status);
  if (!codec)
  {
    return Status(StatusCode::Unsupported,
      path + ": compression \"" + compression + "\" is not known to this version");
  }
  const Status valid = header.Validate();
  if (!valid.IsOk())
  {
    return Status(StatusCode::Corrupt, path + ": " + valid.GetMessage());
  }
  return header;
}

Result<std::string> BlockedVolumeHeader::ReadText(FileSystem& files, const std::string& path)
{
  const auto file = files.OpenForReading(path);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  const std::uint64_t size = (*file)->GetSize();
  if (size > MaximumSize)
  {
    return Status(StatusCode::Corrupt, path + ": is larger than a header can be");
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  ISOSURFACE_RETURN_IF_ERROR((*file)->Read(0, text.size(), text.data()));
  return text;
}

Result<BlockedVolumeHeader> BlockedVolumeHeader::Read(FileSystem& files, const std::string& path)
{
  const auto text = ReadText(files, path);
  return text.IsOk() ? Parse(*text, path) : text.GetStatus();
}

} // namespace isosurface
