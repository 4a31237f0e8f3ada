// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrPlace.h"

#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/TextFields.h"
#include "Formats/Zarr/JsonField.h"
#include "Formats/Zarr/ZarrArray.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

using Json = nlohmann::json;
using Three = std::array<double, 3>;

/// Coordinates are kept as numbers.
constexpr std::int64_t MaximumCoordinates = std::int64_t{ 1 } << 24;

/// Where a list of numbers has that of x, y or z. Without axes x is the first one; otherwise the list has
/// the order of the array, and numbers of all axes or of these three.
std::size_t FindNumber(const ArrayAxes* axes, std::size_t axis, std::size_t size)
{
  if (!axes)
  {
    return axis;
  }
  const std::array<int, 3> places{ axes->X, axes->Y, axes->Z };
  const int place = places[axis];
  return static_cast<std::size_t>(size != 3
      ? place
      : std::count_if(places.begin(), places.end(), [place](int other) { return other < place; }));
}

/// The numbers of x, y and z in a list.
bool TakeThree(const Json& list, Three& numbers, const ArrayAxes* axes = nullptr)
{
  Three found{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::size_t at = list.is_array() ? FindNumber(axes, axis, list.size()) : 0;
    if (at >= list.size() || !list.is_array() || !list[at].is_number())
    {
      return false;
    }
    found[axis] = list[at].get<double>();
  }
  numbers = found;
  return true;
}

/// Distances of samples, and their units. Attributes of N5, and pixelResolution, have x first; those of
/// arrays of Zarr the order of the array.
struct Resolution
{
  bool IsTold = false;
  Three Distances{ 1, 1, 1 };
  std::array<std::string, 3> Units;

  /// `axes`: null of N5.
  Resolution(const ZarrNode& node, const ArrayAxes* axes)
  {
    const Json& pixel = FindJson(node.Attributes, "pixelResolution");
    const Json& distances = pixel.is_object() ? FindJson(pixel, "dimensions") : pixel;
    this->IsTold = TakeThree(distances, this->Distances) ||
      TakeThree(FindJson(node.Attributes, "resolution"), this->Distances, axes) ||
      TakeThree(FindJson(node.Attributes, "voxel_size"), this->Distances, axes);
    const Json& unit = FindJson(pixel, "unit");
    const Json& units = unit.is_null() ? FindJson(node.Attributes, "units") : unit;
    for (std::size_t axis = 0; axis < 3 && this->IsTold; ++axis)
    {
      const std::size_t at = FindNumber(axes, axis, units.size());
      this->Units[axis] = GetJsonText(units.is_array() && at < units.size() ? units[at] : units);
    }
  }
  bool IsNear(const Resolution& other) const
  {
    return std::equal(this->Distances.begin(), this->Distances.end(), other.Distances.begin(),
      [](double a, double b) { return std::abs(a - b) <= 1e-3 * std::abs(b); });
  }
};

/// A folder's metadata; those of none if they cannot be read.
ZarrNode ReadNode(FileSystem& files, const std::filesystem::path& folder)
{
  auto node =
    folder.empty() ? Result<ZarrNode>(ZarrNode()) : ZarrNode::Read(files, folder.string());
  return node.IsOk() ? std::move(*node) : ZarrNode();
}

/// The number of a level: 2 of "s2".
std::optional<std::int64_t> FindLevelNumber(const std::string& name)
{
  return name.size() > 1 && name[0] == 's' &&
      name.find_first_not_of("0123456789", 1) == std::string::npos
    ? ParseInteger(name.substr(1))
    : std::nullopt;
}

/// The downsampling factors of a level.
Three FindFactors(
  const ZarrNode& node, const std::vector<ZarrNode>& groups, std::optional<std::int64_t> level)
{
  Three factors{ 1, 1, 1 };
  if (TakeThree(FindJson(node.Attributes, "downsamplingFactors"), factors))
  {
    return factors;
  }
  for (const ZarrNode& group : groups)
  {
    for (const char* const name : { "downsamplingFactors", "scales" })
    {
      const Json& list = FindJson(group.Attributes, name);
      const bool has = list.is_array() && level && *level < static_cast<std::int64_t>(list.size());
      if (has && TakeThree(list[static_cast<std::size_t>(*level)], factors))
      {
        return factors;
      }
    }
  }
  return factors;
}

/// The numbers of an array of one axis; nothing if it cannot be read, or is no such array.
std::vector<double> ReadNumbers(FileSystem& files, const std::string& folder, std::int64_t size)
{
  const ZarrNode node = ReadNode(files, folder);
  auto metadata = node.IsArray ? ParseZarrMetadata(node, folder)
                               : Result<ZarrMetadata>(Status(StatusCode::NotFound, folder));
  if (!metadata.IsOk() || metadata->Shape != StoredArray::Numbers{ size } ||
    size > MaximumCoordinates)
  {
    return {};
  }
  ZarrArray array(files, folder, std::move(*metadata), 0);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size) * GetValueSize(array.GetType()));
  if (!array.Read({ 0 }, { size }, bytes.data()).IsOk())
  {
    return {};
  }
  std::vector<double> numbers;
  DispatchValueType(array.GetType(),
    [&](auto zero)
    {
      for (std::size_t at = 0; at < bytes.size(); at += sizeof(zero))
      {
        auto number = zero;
        std::memcpy(&number, &bytes[at], sizeof(number));
        numbers.push_back(static_cast<double>(number));
      }
    });
  return numbers;
}

/// The numbers of the array beside another one that has the name of an axis, and their unit.
std::vector<double> ReadCoordinates(FileSystem& files, const std::string& folder,
  const std::string& name, std::int64_t size, std::string& unit)
{
  const std::string path = (std::filesystem::path(folder).parent_path() / name).string();
  const bool isName =
    !name.empty() && name.find('/') == std::string::npos && name.find("..") == std::string::npos;
  std::vector<double> numbers =
    isName && path != folder ? ReadNumbers(files, path, size) : std::vector<double>();
  unit = numbers.empty() ? "" : FindJsonText(ReadNode(files, path).Attributes, "units");
  return numbers;
}

/// The distance of numbers in equal steps, to a thousandth of one; nothing if there is none.
std::optional<double> FindStep(const std::vector<double>& numbers)
{
  const double step = (numbers.back() - numbers.front()) / static_cast<double>(numbers.size() - 1);
  for (std::size_t n = 0; n < numbers.size(); ++n)
  {
    if (!(std::abs(numbers[n] - (numbers[0] + step * static_cast<double>(n))) <=
          1e-3 * std::abs(step)))
    {
      return std::nullopt;
    }
  }
  return step != 0 && std::isfinite(step) ? std::optional(step) : std::nullopt;
}

} // namespace

bool TakeTransform(const Json& transform, ZarrPlace& place)
{
  const Json& axes = FindJson(transform, "axes");
  const Json& scale = FindJson(transform, "scale");
  if (!axes.is_array() || !scale.is_array() || axes.size() != scale.size())
  {
    return false;
  }
  const auto number = [](const Json& list, std::size_t at, double otherwise)
  {
    return list.is_array() && at < list.size() && list[at].is_number() ? list[at].get<double>()
                                                                       : otherwise;
  };
  for (std::size_t at = 0; at < axes.size(); ++at)
  {
    const std::string name = LowerText(GetJsonText(axes[at]));
    const std::size_t axis = name.size() == 1 ? std::string("xyz").find(name) : std::string::npos;
    if (axis != std::string::npos)
    {
      const Json& units = FindJson(transform, "units");
      place.Spacing[axis] = number(scale, at, 1);
      place.Origin[axis] = number(FindJson(transform, "translate"), at, 0);
      place.Units[axis] = units.is_array() && at < units.size() ? GetJsonText(units[at]) : "";
    }
  }
  return true;
}

ZarrPlace FindZarrPlace(
  FileSystem& files, const std::string& folder, const ZarrNode& node, const ArrayAxes& arrayAxes)
{
  const ArrayAxes* const axes = node.Version == 5 ? nullptr : &arrayAxes;
  ZarrPlace place;
  if (TakeTransform(FindJson(node.Attributes, "transform"), place))
  {
    return place;
  }
  const std::filesystem::path path(folder);
  const std::filesystem::path parent = path.has_parent_path() ? path.parent_path() : ".";
  const std::vector<ZarrNode> groups = { ReadNode(files, parent),
    ReadNode(files, parent.parent_path()) };
  const auto level = FindLevelNumber(path.filename().string());
  const Three factors = FindFactors(node, groups, level);
  const Resolution own(node, axes);
  Resolution full(groups[0], axes);
  full = full.IsTold ? full : Resolution(groups[1], axes);
  if (!full.IsTold && level && *level > 0)
  {
    full = Resolution(ReadNode(files, parent / "s0"), axes);
  }
  const bool isOfLevel = own.IsTold && full.IsTold && !own.IsNear(full);
  const Resolution& known = own.IsTold ? own : full;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    place.Spacing[axis] = known.Distances[axis] * (isOfLevel ? 1 : factors[axis]);
    place.Origin[axis] = place.Spacing[axis] * (0.5 - 0.5 / factors[axis]);
  }
  TakeThree(FindJson(node.Attributes, "offset"), place.Origin, axes);
  place.Units = known.Units[0].empty() ? full.Units : known.Units;
  return place;
}

void TakeCoordinates(FileSystem& files, const std::string& folder,
  const std::array<std::string, 3>& names, GridGeometry& grid, std::string& told)
{
  std::array<std::string, 3> units;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t size = grid.GetDimensions()[axis];
    const std::vector<double> numbers =
      ReadCoordinates(files, folder, names[axis], size, units[axis]);
    if (numbers.empty())
    {
      continue;
    }
    const auto step = size > 1 ? FindStep(numbers) : std::optional(grid.Spacing[axis]);
    if (!step)
    {
      AddNote(
        told, "the coordinates \"" + names[axis] + "\" have no equal steps, and are not kept");
      units[axis].clear();
      continue;
    }
    grid.Origin[axis] = numbers.front();
    grid.Spacing[axis] = std::abs(*step);
    grid.Direction[4 * axis] = *step < 0 ? -1 : 1;
  }
  TakeLengthUnits(units, grid, told);
}

void TakeTimes(FileSystem& files, const std::string& folder, const std::string& name,
  std::vector<double>& times, std::string& told)
{
  std::string unit;
  std::vector<double> numbers =
    ReadCoordinates(files, folder, name, static_cast<std::int64_t>(times.size()), unit);
  if (!numbers.empty() &&
    std::all_of(numbers.begin(), numbers.end(), [](double time) { return std::isfinite(time); }))
  {
    times = std::move(numbers);
  }
  if (!unit.empty())
  {
    AddNote(told, "the unit of times, " + unit + ", is not kept");
  }
}

} // namespace isosurface
