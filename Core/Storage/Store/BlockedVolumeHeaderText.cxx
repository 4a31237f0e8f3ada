// SPDX-License-Identifier: BSD-3-Clause
// The text of a header: BlockedVolumeHeader::Format(), Parse() and Read().
#include "Ground/Base/Checksum.h"
#include "Storage/Record/BlockCompression.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/JsonDocument.h"
#include "Storage/Store/StoreLists.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace isosurface
{

// How nlohmann_json formats them.
static void to_json(Json& json, const StoreDescription& store)
{
  json = { { "blocks", store.Blocks }, { "bytes", store.Bytes },
    { "checksum", FormatChecksum(store.Checksum) } };
  std::string seals;
  for (const std::uint64_t seal : store.Seals)
  {
    seals += FormatChecksum(seal);
  }
  if (!seals.empty())
  {
    json["seals"] = seals;
  }
}

static void to_json(Json& json, const OverviewDescription& overview)
{
  json = { { "numberOfLevels", overview.NumberOfLevels }, { "stores", overview.NumberOfStores } };
}

static void to_json(Json& json, const ArrayDescription& array)
{
  json = { { "name", array.Name }, { "type", GetValueTypeName(array.Type) },
    { "components", array.Components } };
  if (!array.Unit.empty())
  {
    json["unit"] = array.Unit;
  }
}

static void to_json(Json& json, const SourceRecord& record)
{
  json = { { "path", record.Path }, { "absolutePath", record.AbsolutePath },
    { "within", record.Within }, { "axes", record.Axes }, { "step", record.Step },
    { "arrays", record.Arrays }, { "files", record.State.Files }, { "bytes", record.State.Bytes },
    { "modified", record.State.Modified }, { "metadata", FormatChecksum(record.Metadata) } };
  if (record.Chunk)
  {
    json["chunk"] = *record.Chunk;
  }
}

namespace
{

constexpr const char* FormatName = "ScalableIsosurface blocked volume";
constexpr std::int64_t MaximumStores = BlockedVolumeHeader::MaximumStores;

/// Reads an array of numbers, `reason` if isValid(json) is false for one.
template <typename Numbers, typename IsValid>
void ReadNumbers(JsonMembers& members, const char* name, Numbers& numbers, const IsValid& isValid,
  const char* reason)
{
  const Json& array = members.GetArray(name, numbers.size());
  for (std::size_t index = 0; index < array.size(); ++index)
  {
    if (!isValid(array[index]))
    {
      members.Fail(name, reason);
      return;
    }
    array[index].get_to(numbers[index]);
  }
}

bool IsNumber(const Json& json)
{
  return json.is_number();
}

GridGeometry ReadGrid(JsonMembers members)
{
  GridGeometry grid;
  const auto isCoordinate = [](const Json& json)
  {
    return json.is_number_integer() &&
      !(json.is_number_unsigned() &&
        json.get<std::uint64_t>() >
          static_cast<std::uint64_t>(BlockedVolumeHeader::MaximumCoordinate));
  };
  ReadNumbers(
    members, "extent", grid.Extent, isCoordinate, "is not an array of integers up to 2^40");
  const char* const reason = "is not an array of numbers";
  ReadNumbers(members, "origin", grid.Origin, IsNumber, reason);
  ReadNumbers(members, "spacing", grid.Spacing, IsNumber, reason);
  ReadNumbers(members, "direction", grid.Direction, IsNumber, reason);
  grid.Unit = members.Has("unit") ? FindLengthUnit(members.GetString("unit")) : LengthUnit::Unknown;
  return grid;
}

/// The coordinates of a rectilinear grid, which has three lists of numbers; nothing of another
/// grid.
std::optional<GridLines> ReadLines(JsonMembers members)
{
  if (!members.Has("coordinates"))
  {
    return std::nullopt;
  }
  GridLines lines;
  const auto isList = [](const Json& list)
  { return list.is_array() && std::all_of(list.begin(), list.end(), IsNumber); };
  ReadNumbers(members, "coordinates", lines.Coordinates, isList, "is not three arrays of numbers");
  return members.IsOk() ? std::optional<GridLines>(lines) : std::nullopt;
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

void ReadDistribution(JsonMembers members, BlockedVolumeHeader& header)
{
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

std::vector<ArrayDescription> ReadArrays(JsonMembers& document)
{
  std::vector<ArrayDescription> arrays;
  // All together: what is made of them has an entry for each component.
  std::int64_t left = BlockDirectory::MaximumSegments;
  document.Visit("arrays", JsonMembers::AnySize,
    [&](JsonMembers& members)
    {
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
      array.Unit = members.Has("unit") ? members.GetString("unit") : "";
      arrays.push_back(array);
    });
  return arrays;
}

/// `lists`: of the text that the members are of; null if all of it was parsed.
std::vector<StoreDescription> ReadStores(
  JsonMembers& members, std::uint32_t count, std::size_t variables, StoreLists* lists)
{
  std::vector<StoreDescription> stores;
  if (lists)
  {
    const Json& number = members.GetArray("stores", 1);
    if (members.IsOk())
    {
      stores = std::move(lists->Lists[number[0].get<std::size_t>()]);
    }
    const bool fits = stores.size() == count &&
      std::all_of(stores.begin(), stores.end(),
        [&](const StoreDescription& store)
        { return store.Seals.empty() || store.Seals.size() == 1 + variables; });
    if (!fits)
    {
      members.Fail("stores", "does not fit the volume");
    }
    return stores;
  }
  members.Visit("stores", count,
    [&](JsonMembers& store)
    {
      stores.push_back(
        { store.GetUnsigned("blocks"), store.GetUnsigned("bytes"), store.GetChecksum("checksum"),
          store.Has("seals") ? store.GetChecksums("seals", 1 + variables)
                             : std::vector<std::uint64_t>() });
    });
  return stores;
}

/// SourceRecord::Validate() checks the rest.
SourceRecord ReadSource(JsonMembers members)
{
  constexpr std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
  SourceRecord record;
  record.Path = members.GetString("path");
  record.AbsolutePath = members.GetString("absolutePath");
  record.Within = members.GetString("within");
  record.Axes = members.GetString("axes");
  record.Step = static_cast<std::size_t>(members.GetInteger("step", 0, SourceRecord::MaximumChunk));
  record.Arrays.resize(members.GetArray("arrays", JsonMembers::AnySize).size());
  ReadNumbers(
    members, "arrays", record.Arrays, [](const Json& name) { return name.is_string(); },
    "is not an array of strings");
  const auto isSize = [](const Json& json)
  {
    return json.is_number_unsigned() &&
      json.get<std::uint64_t>() <= static_cast<std::uint64_t>(SourceRecord::MaximumChunk);
  };
  if (members.Has("chunk"))
  {
    ReadNumbers(
      members, "chunk", record.Chunk.emplace(), isSize, "is not an array of numbers of vertices");
  }
  record.State.Files = members.GetUnsigned("files");
  record.State.Bytes = members.GetUnsigned("bytes");
  record.State.Modified = members.GetInteger("modified", -maximum, maximum);
  record.Metadata = members.GetChecksum("metadata");
  return record;
}

TimeStepDescription ReadTimeStep(
  JsonMembers& members, const BlockedVolumeHeader& header, StoreLists* lists)
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
  step.Stores = ReadStores(members, header.NumberOfStores, variables.GetCount(), lists);
  members.Visit("overviews", header.Overviews.size(),
    [&](JsonMembers& overview)
    {
      const OverviewDescription& described = header.Overviews[step.Overviews.size()];
      step.Overviews.push_back(
        ReadStores(overview, described.NumberOfStores, variables.GetCount(), lists));
    });
  if (members.Has("source"))
  {
    step.Source = ReadSource(members.GetObject("source"));
  }
  if (members.Has("copyOf"))
  {
    step.CopyOf = ReadSource(members.GetObject("copyOf"));
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

Json FormatTimeStep(const TimeStepDescription& step, const ArrayVariables& variables)
{
  Json json = { { "time", step.Time ? Json(*step.Time) : Json() }, { "folder", step.Folder },
    { "ranges", Json::array() }, { "stores", step.Stores }, { "overviews", Json::array() } };
  for (std::size_t variable = 0; variable < step.Ranges.size(); ++variable)
  {
    json["ranges"].push_back(FormatRange(variables[variable].Type, step.Ranges[variable]));
  }
  for (const std::vector<StoreDescription>& stores : step.Overviews)
  {
    json["overviews"].push_back({ { "stores", stores } });
  }
  if (step.Source)
  {
    json["source"] = *step.Source;
  }
  if (step.CopyOf)
  {
    json["copyOf"] = *step.CopyOf;
  }
  return json;
}

/// `lists`: those of the text; null: parses all of it as a document.
Result<BlockedVolumeHeader> ParseText(
  const std::string& text, const std::string& path, StoreLists* lists)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto document,
    ParseDocument(
      text, path, FormatName, BlockedVolumeHeader::FormatVersion, lists ? &lists->Rest : nullptr));
  Status status;
  JsonMembers members(document, path, "", status);
  BlockedVolumeHeader header;
  header.Grid = ReadGrid(members.GetObject("grid"));
  header.Lines = ReadLines(members.GetObject("grid"));
  ReadBlocks(members, header);
  ReadDistribution(members.GetObject("distribution"), header);
  const std::string compression = members.GetString("compression");
  const auto codec = FindCodec(compression);
  header.Compression.Codec = codec.value_or(SegmentCodec::None);
  if (header.Compression.Codec != SegmentCodec::None)
  {
    header.Compression.Level = static_cast<int>(members.GetInteger("compressionLevel", 1, 99));
  }
  header.Arrays = ReadArrays(members);
  const int largestNumberOfLevels = GetMaximumNumberOfLevels(header.BlockSize);
  members.Visit("overviews", JsonMembers::AnySize,
    [&](JsonMembers& overview)
    {
      header.Overviews.push_back(
        { static_cast<int>(overview.GetInteger("numberOfLevels", 1, largestNumberOfLevels)),
          static_cast<std::uint32_t>(overview.GetInteger("stores", 1, MaximumStores)) });
    });
  members.Visit("timeSteps", JsonMembers::AnySize,
    [&](JsonMembers& step) { header.TimeSteps.push_back(ReadTimeStep(step, header, lists)); });
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

} // namespace

std::string BlockedVolumeHeader::Format() const
{
  Json document;
  document["format"] = FormatName;
  document["formatVersion"] = FormatVersion;
  document["grid"] = { { "extent", this->Grid.Extent }, { "origin", this->Grid.Origin },
    { "spacing", this->Grid.Spacing }, { "direction", this->Grid.Direction } };
  if (this->Grid.Unit != LengthUnit::Unknown)
  {
    document["grid"]["unit"] = GetLengthUnitName(this->Grid.Unit);
  }
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
  document["arrays"] = this->Arrays;
  document["overviews"] = this->Overviews;
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
  if (auto lists = CutStoreLists(text))
  {
    auto header = ParseText(text, path, &*lists);
    if (header.IsOk())
    {
      return header;
    }
    // What is wrong can be said more clearly if all of it is parsed.
  }
  return ParseText(text, path, nullptr);
}

Result<std::string> BlockedVolumeHeader::ReadText(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  const std::uint64_t size = file->GetSize();
  if (size > MaximumSize)
  {
    return Status(StatusCode::Corrupt, path + ": is larger than a header can be");
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  ISOSURFACE_RETURN_IF_ERROR(file->Read(0, text.size(), text.data()));
  return text;
}

Result<BlockedVolumeHeader> BlockedVolumeHeader::Read(FileSystem& files, const std::string& path)
{
  const auto text = ReadText(files, path);
  return text.IsOk() ? Parse(*text, path) : text.GetStatus();
}

} // namespace isosurface
