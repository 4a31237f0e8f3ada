// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockedVolumeHeader.h"

#include "Record/BlockRecord.h"
#include "Store/BlockDirectory.h"
#include "Store/JsonDocument.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <type_traits>

namespace isosurface
{
namespace
{

constexpr const char* FormatName = "ScalableIsosurface blocked volume";
constexpr std::int64_t MaximumStores = 1 << 20;
constexpr std::int64_t MaximumCoordinate = std::int64_t{ 1 } << 40;
/// So that three numbers a vertex (its grid edges) fit 63 bits.
constexpr double MaximumVertices = 1152921504606846976.0; // 2^60

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
    array.Components =
      static_cast<int>(members.GetInteger("components", 1, BlockDirectory::MaximumSegments));
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
  JsonMembers& members, const BlockedVolumeHeader& header, std::int64_t version, Status& status)
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
  if (version > 1)
  {
    const Json& overviews = members.GetArray("overviews", header.Overviews.size());
    for (std::size_t index = 0; index < overviews.size() && status.IsOk(); ++index)
    {
      JsonMembers overview = members.GetElement("overviews", overviews, index);
      step.Overviews.push_back(
        ReadStores(overview, header.Overviews[index].NumberOfStores, status));
    }
  }
  return step;
}

Status MakeMemberError(const char* member, const std::string& reason)
{
  return Status(StatusCode::InvalidArgument, std::string("member ") + member + " " + reason);
}

bool IsUtf8(const std::string& text)
{
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::ignore)) == Json(text);
}

Status ValidateGrid(const GridGeometry& grid)
{
  double vertices = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t low = grid.Extent[2 * axis];
    const std::int64_t high = grid.Extent[2 * axis + 1];
    if (low < -MaximumCoordinate || high > MaximumCoordinate || low > high)
    {
      return MakeMemberError("grid.extent", "is empty or beyond 2^40");
    }
    vertices *= static_cast<double>(high - low + 1);
  }
  if (vertices > MaximumVertices)
  {
    return MakeMemberError("grid.extent", "has more than 2^60 vertices");
  }
  bool isFinite = true;
  for (std::size_t axis = 0; axis < 9; ++axis)
  {
    isFinite = isFinite && std::isfinite(grid.Direction[axis]) &&
      std::isfinite(grid.Origin[axis % 3]) && std::isfinite(grid.Spacing[axis % 3]);
  }
  return isFinite
    ? Status::Ok()
    : MakeMemberError("grid", "has an origin, spacing or direction that is not finite");
}

Status ValidateStores(
  const char* member, const std::vector<StoreDescription>& stores, std::uint64_t expected)
{
  std::uint64_t blocks = 0;
  for (const StoreDescription& store : stores)
  {
    if (store.Blocks > expected - blocks || store.Bytes % BlockRecord::Alignment != 0 ||
      store.Bytes >> 62 != 0)
    {
      return MakeMemberError(member, "has impossible numbers of blocks or bytes");
    }
    blocks += store.Blocks;
  }
  return blocks == expected ? Status::Ok()
                            : MakeMemberError(member, "does not have as many blocks as the volume");
}

Status ValidateTimeStep(const TimeStepDescription& step, const BlockedVolumeHeader& header)
{
  if (step.Time && !std::isfinite(*step.Time))
  {
    return MakeMemberError("timeSteps[].time", "is not finite");
  }
  if (step.Folder.size() < 6 || step.Folder.size() > 18 ||
    step.Folder.find_first_not_of("0123456789") != std::string::npos)
  {
    return MakeMemberError("timeSteps[].folder", "is not a number of 6 to 18 digits");
  }
  if (step.Ranges.size() != header.GetVariables().GetCount() ||
    step.Stores.size() != header.NumberOfStores || step.Overviews.size() != header.Overviews.size())
  {
    return MakeMemberError(
      "timeSteps[]", "does not fit the numbers of arrays, stores and overviews");
  }
  return ValidateStores("timeSteps[].stores", step.Stores,
    static_cast<std::uint64_t>(header.GetBlockGrid().GetNumberOfBlocks()));
}

/// An overview is made of a volume of several blocks, and it has all blocks in its stores.
Status ValidateOverviews(const BlockedVolumeHeader& header)
{
  BlockGrid finer = header.GetBlockGrid();
  for (std::size_t index = 0; index < header.Overviews.size(); ++index)
  {
    const OverviewDescription& overview = header.Overviews[index];
    if (overview.NumberOfLevels < 1 ||
      overview.NumberOfLevels > GetMaximumNumberOfLevels(header.BlockSize) ||
      overview.NumberOfStores < 1 || overview.NumberOfStores > MaximumStores)
    {
      return MakeMemberError("overviews", "has impossible numbers of levels or stores");
    }
    if (finer.GetNumberOfBlocks() == 1)
    {
      return MakeMemberError("overviews", "has an overview of a single block");
    }
    Index3 dimensions = finer.GetDimensions();
    for (std::int64_t& vertices : dimensions)
    {
      vertices = ((vertices - 1) >> finer.GetNumberOfLevels()) + 1;
    }
    finer = BlockGrid(dimensions, header.BlockSize, overview.NumberOfLevels);
    for (const TimeStepDescription& step : header.TimeSteps)
    {
      if (step.Overviews[index].size() != overview.NumberOfStores)
      {
        return MakeMemberError("timeSteps[].overviews", "does not fit the number of stores");
      }
      ISOSURFACE_RETURN_IF_ERROR(ValidateStores("timeSteps[].overviews", step.Overviews[index],
        static_cast<std::uint64_t>(finer.GetNumberOfBlocks())));
    }
  }
  return Status::Ok();
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

} // namespace

std::optional<std::size_t> BlockedVolumeHeader::FindArray(const std::string& name) const
{
  for (std::size_t index = 0; index < this->Arrays.size(); ++index)
  {
    if (this->Arrays[index].Name == name)
    {
      return index;
    }
  }
  return std::nullopt;
}

bool BlockedVolumeHeader::HasFolder(const std::string& folder) const
{
  return std::any_of(this->TimeSteps.begin(), this->TimeSteps.end(),
    [&](const TimeStepDescription& step) { return step.Folder == folder; });
}

Status BlockedVolumeHeader::ValidateVolume() const
{
  ISOSURFACE_RETURN_IF_ERROR(ValidateGrid(this->Grid));
  if (!IsBlockSize(this->BlockSize))
  {
    return MakeMemberError("blockSize", "is not 16, 32 or 64");
  }
  double blocks = 1;
  for (const std::int64_t vertices : this->Grid.GetDimensions())
  {
    blocks *= std::ceil(static_cast<double>(vertices) / this->BlockSize);
  }
  if (blocks > std::numeric_limits<std::uint32_t>::max())
  {
    return MakeMemberError("blockSize", "gives more than 2^32 blocks");
  }
  if (this->NumberOfStores < 1 || this->NumberOfStores > MaximumStores)
  {
    return MakeMemberError("stores", "is not from 1 to " + std::to_string(MaximumStores));
  }
  if (!this->Compression.IsValid())
  {
    return MakeMemberError("compressionLevel", "is beyond those of the codec");
  }
  std::set<std::string> names;
  std::size_t components = 0;
  for (const ArrayDescription& array : this->Arrays)
  {
    if (array.Components < 1)
    {
      return MakeMemberError("arrays[].components", "is below 1");
    }
    components += static_cast<std::size_t>(array.Components);
    if (!names.insert(array.Name).second || !IsUtf8(array.Name))
    {
      return MakeMemberError("arrays[].name", "is there twice or not UTF-8: " + array.Name);
    }
  }
  const int mostLevels = GetMaximumNumberOfLevels(this->BlockSize);
  if (this->NumberOfLevels < 0 || this->NumberOfLevels > mostLevels)
  {
    return MakeMemberError("numberOfLevels", "is not from 1 to " + std::to_string(mostLevels));
  }
  // The coarsest overview has all levels that a block can have.
  const auto levels = static_cast<std::size_t>(mostLevels);
  if (this->Arrays.empty() || components > BlockDirectory::MaximumSegments / levels)
  {
    return MakeMemberError("arrays",
      "does not have from 1 to " + std::to_string(BlockDirectory::MaximumSegments / levels) +
        " components in all");
  }
  return Status::Ok();
}

Status BlockedVolumeHeader::Validate() const
{
  ISOSURFACE_RETURN_IF_ERROR(this->ValidateVolume());
  if (this->TimeSteps.empty())
  {
    return MakeMemberError("timeSteps", "has no element");
  }
  const TimeStepDescription* before = nullptr;
  for (const TimeStepDescription& step : this->TimeSteps)
  {
    ISOSURFACE_RETURN_IF_ERROR(ValidateTimeStep(step, *this));
    if (this->TimeSteps.size() > 1 && (!step.Time || (before && !(*before->Time < *step.Time))))
    {
      return MakeMemberError("timeSteps[].time", "is not above that of the time step before");
    }
    before = &step;
  }
  return ValidateOverviews(*this);
}

BlockGrid BlockedVolumeHeader::GetBlockGrid() const
{
  return BlockGrid(this->Grid.GetDimensions(), this->BlockSize, this->NumberOfLevels);
}

BlockedVolumeHeader BlockedVolumeHeader::MakeOverview(std::size_t overview) const
{
  int level = this->GetBlockGrid().GetNumberOfLevels();
  for (std::size_t finer = 0; finer < overview; ++finer)
  {
    level += this->Overviews[finer].NumberOfLevels;
  }
  BlockedVolumeHeader header = *this;
  header.Grid = this->Grid.Coarsen(level);
  header.NumberOfLevels = this->Overviews[overview].NumberOfLevels;
  header.NumberOfStores = this->Overviews[overview].NumberOfStores;
  header.Overviews.clear();
  for (TimeStepDescription& step : header.TimeSteps)
  {
    step.Folder = GetOverviewFolder(step.Folder, overview);
    step.Stores = step.Overviews[overview];
    step.Overviews.clear();
  }
  return header;
}

std::string BlockedVolumeHeader::Format() const
{
  Json document;
  document["format"] = FormatName;
  const int levels = this->GetBlockGrid().GetNumberOfLevels();
  const bool hasOverviews =
    !this->Overviews.empty() || levels != GetMaximumNumberOfLevels(this->BlockSize);
  document["formatVersion"] = hasOverviews ? 2 : 1;
  document["grid"] = { { "extent", this->Grid.Extent }, { "origin", this->Grid.Origin },
    { "spacing", this->Grid.Spacing }, { "direction", this->Grid.Direction } };
  document["blockSize"] = this->BlockSize;
  document["ghostLayers"] = 1;
  document["numberOfLevels"] = levels;
  document["stores"] = this->NumberOfStores;
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
  const ArrayVariables variables = this->GetVariables();
  if (hasOverviews)
  {
    document["overviews"] = Json::array();
    for (const OverviewDescription& overview : this->Overviews)
    {
      document["overviews"].push_back(
        { { "numberOfLevels", overview.NumberOfLevels }, { "stores", overview.NumberOfStores } });
    }
  }
  document["timeSteps"] = Json::array();
  for (const TimeStepDescription& step : this->TimeSteps)
  {
    Json json = { { "time", nullptr }, { "folder", step.Folder }, { "ranges", Json::array() },
      { "stores", FormatStores(step.Stores) } };
    if (step.Time)
    {
      json["time"] = *step.Time;
    }
    for (std::size_t variable = 0; variable < step.Ranges.size(); ++variable)
    {
      json["ranges"].push_back(FormatRange(variables[variable].Type, step.Ranges[variable]));
    }
    if (hasOverviews)
    {
      json["overviews"] = Json::array();
      for (const std::vector<StoreDescription>& stores : step.Overviews)
      {
        json["overviews"].push_back({ { "stores", FormatStores(stores) } });
      }
    }
    document["timeSteps"].push_back(std::move(json));
  }
  return FormatDocument(std::move(document));
}

Result<BlockedVolumeHeader> BlockedVolumeHeader::Parse(
  const std::string& text, const std::string& path)
{
  const auto document = ParseDocument(text, path, FormatName, FormatVersion);
  if (!document.IsOk())
  {
    return document.GetStatus();
  }
  Status status;
  JsonMembers members(*document, path, "", status);
  BlockedVolumeHeader header;
  header.Grid = ReadGrid(members, path, status);
  header.BlockSize = static_cast<int>(members.GetInteger("blockSize", 16, 64));
  if (!IsBlockSize(header.BlockSize))
  {
    members.Fail("blockSize", "is not 16, 32 or 64");
  }
  const auto version = (*document)["formatVersion"].get<std::int64_t>();
  const int mostLevels = GetMaximumNumberOfLevels(header.BlockSize);
  header.NumberOfStores =
    static_cast<std::uint32_t>(members.GetInteger("stores", 1, MaximumStores));
  members.GetInteger("ghostLayers", 1, 1);
  header.NumberOfLevels = static_cast<int>(
    members.GetInteger("numberOfLevels", version > 1 ? 1 : mostLevels, mostLevels));
  JsonMembers distribution(members.GetAny("distribution"), path, "distribution.", status);
  const auto method = FindDistribution(distribution.GetString("method"));
  if (!method)
  {
    distribution.Fail("method", "is not known");
  }
  header.Distribution = method.value_or(DistributionMethod::Greedy);
  header.RandomSeed = distribution.GetUnsigned("seed");
  const std::string compression = members.GetString("compression");
  const auto codec = FindCodec(compression);
  header.Compression.Codec = codec.value_or(SegmentCodec::None);
  if (header.Compression.Codec != SegmentCodec::None)
  {
    header.Compression.Level = static_cast<int>(members.GetInteger("compressionLevel", 1, 99));
  }
  header.Arrays = ReadArrays(members, status);
  if (version > 1)
  {
    header.Overviews = ReadOverviews(members, mostLevels, status);
  }
  const Json& steps = members.GetArray("timeSteps", JsonMembers::AnySize);
  for (std::size_t index = 0; index < steps.size() && status.IsOk(); ++index)
  {
    JsonMembers step = members.GetElement("timeSteps", steps, index);
    header.TimeSteps.push_back(ReadTimeStep(step, header, version, status));
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

Result<BlockedVolumeHeader> BlockedVolumeHeader::Read(FileSystem& files, const std::string& path)
{
  const auto text = ReadText(files, path, MaximumSize);
  return text.IsOk() ? Parse(*text, path) : text.GetStatus();
}

std::string GetStoresFolder(const std::string& path)
{
  return path + ".stores";
}

std::string GetOverviewFolder(const std::string& generation, std::size_t overview)
{
  return generation + "/overview-" + std::to_string(overview + 1);
}

std::string GetStoreFolder(
  const std::string& path, const std::string& generation, std::uint32_t store)
{
  char name[32];
  std::snprintf(name, sizeof(name), "/store-%05u", store);
  return GetStoresFolder(path) + "/" + generation + name;
}

} // namespace isosurface
