// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/PlainFormats.h"

#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/BinaryHeader.h"
#include "Formats/Source/ConvertedSource.h"
#include "Formats/Source/PermutedSource.h"
#include "Ground/Volume/BoxSource.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t HeaderSize = 1024;
constexpr int HalfMode = 12;
constexpr std::int32_t ImodStamp = 1146047817;
constexpr double Pi = 3.14159265358979323846;

/// Places of the fields in the header, in bytes.
enum Place : std::size_t
{
  Sizes = 0,
  Mode = 12,
  Starts = 16,
  Intervals = 28,
  Lengths = 40,
  Angles = 52,
  Axes = 64,
  SpaceGroup = 88,
  ExtendedSize = 92,
  Stamp = 152,
  ImodFlags = 156,
  Origins = 196,
  Machine = 212
};

template <typename T>
std::array<T, 3> GetThree(const BinaryHeader& header, std::size_t place)
{
  return { header.Get<T>(place), header.Get<T>(place + 4), header.Get<T>(place + 8) };
}

class MrcParser
{
public:
  explicit MrcParser(BinaryHeader& header)
    : Header(header)
  {
  }

  /// Where samples of the time step are, with their columns, rows and sections as x, y and z.
  Result<RawVolume> TakeSamples(std::size_t step)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->FindByteOrder());
    RawVolume raw;
    raw.IsBigEndian = this->Header.IsBigEndian();
    raw.IsGzip = this->Header.IsGzip();
    raw.Paths = { this->Header.GetPath() };
    ISOSURFACE_RETURN_IF_ERROR(this->TakeType(raw));
    ISOSURFACE_RETURN_IF_ERROR(this->TakeSizes());
    double bytes = static_cast<double>(GetValueSize(raw.Type));
    raw.Grid.Extent = {};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      raw.Grid.Extent[2 * axis + 1] = this->Size[axis] - 1;
      bytes *= static_cast<double>(this->Size[axis]);
    }
    const auto extended = this->Header.Get<std::int32_t>(ExtendedSize);
    const double offset =
      HeaderSize + static_cast<double>(extended) + bytes * static_cast<double>(step);
    if (extended < 0 || offset + bytes >= 0x1p53)
    {
      return this->Header.MakeError(StatusCode::Corrupt, "the place of its samples is impossible");
    }
    (raw.IsGzip ? raw.Skip : raw.Offset) = static_cast<std::uint64_t>(offset);
    return raw;
  }

  std::int64_t GetSteps() const { return this->Steps; }
  /// Images of one section each, as those of a tilt series, have no distance.
  bool IsStackOfImages() const
  {
    return this->Header.Get<std::int32_t>(SpaceGroup) == 0 &&
      this->Header.Get<std::int32_t>(Intervals + 8) == 1 && this->Size[2] > 1;
  }
  /// Which of x, y and z the columns, rows and sections are.
  const std::array<std::size_t, 3>& GetAxes() const { return this->To; }

  GridGeometry FindGrid() const
  {
    GridGeometry grid;
    const auto intervals = GetThree<std::int32_t>(this->Header, Intervals);
    const auto lengths = GetThree<float>(this->Header, Lengths);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      grid.Extent[2 * this->To[axis]] = 0;
      grid.Extent[2 * this->To[axis] + 1] = this->Size[axis] - 1;
      const double spacing = static_cast<double>(lengths[axis]) / intervals[axis];
      const bool isTold = std::isfinite(spacing) && spacing > 0;
      grid.Spacing[axis] = isTold ? spacing : 1;
      grid.Unit = isTold ? LengthUnit::Angstrom : grid.Unit;
    }
    this->TakeAngles(grid);
    const auto origin = GetThree<float>(this->Header, Origins);
    if (origin != std::array<float, 3>{})
    {
      std::copy(origin.begin(), origin.end(), grid.Origin.begin());
      return grid;
    }
    // The first column, row and section, as a place in the cell.
    const auto starts = GetThree<std::int32_t>(this->Header, Starts);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::size_t to = this->To[axis];
      for (std::size_t row = 0; row < 3; ++row)
      {
        grid.Origin[row] += grid.Direction[3 * row + to] * grid.Spacing[to] * starts[axis];
      }
    }
    return grid;
  }

private:
  Status FindByteOrder()
  {
    const auto machine = this->Header.Get<std::uint8_t>(Machine);
    const auto isPossible = [this]
    {
      const auto axes = GetThree<std::int32_t>(this->Header, Axes);
      const auto mode = this->Header.Get<std::int32_t>(Mode);
      return mode >= 0 && mode <= 101 &&
        std::all_of(axes.begin(), axes.end(), [](int axis) { return axis >= 0 && axis <= 3; });
    };
    this->Header.SetBigEndian(machine == 0x11);
    if (!isPossible())
    {
      this->Header.SetBigEndian(!this->Header.IsBigEndian());
    }
    return isPossible() ? Status::Ok()
                        : this->Header.MakeError(StatusCode::Corrupt, "it is not an MRC file");
  }

  Status TakeType(RawVolume& raw) const
  {
    const auto mode = this->Header.Get<std::int32_t>(Mode);
    switch (mode)
    {
      case 0:
        raw.Type = this->Header.Get<std::int32_t>(Stamp) == ImodStamp &&
            (this->Header.Get<std::int32_t>(ImodFlags) & 1) == 0
          ? ValueType::UInt8
          : ValueType::Int8;
        return Status::Ok();
      case 1:
        raw.Type = ValueType::Int16;
        return Status::Ok();
      case 2:
        raw.Type = ValueType::Float32;
        return Status::Ok();
      case 6:
      case HalfMode:
        raw.Type = ValueType::UInt16;
        return Status::Ok();
      default:
        return this->Header.MakeError(StatusCode::Unsupported,
          "its mode " + std::to_string(mode) + " is none of 0, 1, 2, 6 and 12");
    }
  }

  Status TakeSizes()
  {
    const auto sizes = GetThree<std::int32_t>(this->Header, Sizes);
    const auto axes = GetThree<std::int32_t>(this->Header, Axes);
    std::array<bool, 3> isTaken{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      if (sizes[axis] < 1)
      {
        return this->Header.MakeError(
          StatusCode::Corrupt, "it has an impossible number of samples");
      }
      this->Size[axis] = sizes[axis];
      // Old files have no order of axes.
      const bool isUnset = axes == std::array<std::int32_t, 3>{};
      this->To[axis] = isUnset ? axis : static_cast<std::size_t>(axes[axis]) - 1;
      if (this->To[axis] > 2 || std::exchange(isTaken[this->To[axis]], true))
      {
        return this->Header.MakeError(StatusCode::Corrupt, "the order of its axes is impossible");
      }
    }
    // Space groups from 401 on are stacks of volumes of as many sections as the cell has.
    const auto group = this->Header.Get<std::int32_t>(SpaceGroup);
    const auto sections = this->Header.Get<std::int32_t>(Intervals + 8);
    if (group >= 401 && group <= 630 && sections > 0 && this->Size[2] > sections)
    {
      if (this->Size[2] % sections != 0)
      {
        return this->Header.MakeError(
          StatusCode::Corrupt, "its sections are no multiple of those of a volume");
      }
      this->Steps = this->Size[2] / sections;
      if (this->Steps > MaximumTimeSteps)
      {
        return this->Header.MakeError(StatusCode::Unsupported, "it has too many time steps");
      }
      this->Size[2] = sections;
    }
    return Status::Ok();
  }

  /// The directions of the cell: x along its first side, y in the plane of the first two.
  void TakeAngles(GridGeometry& grid) const
  {
    const auto angles = GetThree<float>(this->Header, Angles);
    const bool isRight = angles == std::array<float, 3>{ 90, 90, 90 };
    const auto isPossible = [](float angle) { return angle > 0 && angle < 180; };
    if (isRight || !std::all_of(angles.begin(), angles.end(), isPossible))
    {
      return;
    }
    const auto cosine = [&angles](std::size_t angle)
    { return angles[angle] == 90.0F ? 0.0 : std::cos(angles[angle] * Pi / 180); };
    const double alpha = cosine(0);
    const double beta = cosine(1);
    const double gamma = cosine(2);
    const double sine = std::sqrt(1 - gamma * gamma);
    const double side = (alpha - beta * gamma) / sine;
    const double height = std::sqrt(std::max(0.0, 1 - beta * beta - side * side));
    grid.Direction = { 1, gamma, beta, 0, sine, side, 0, 0, height };
  }

  BinaryHeader& Header;
  Index3 Size{};
  std::array<std::size_t, 3> To{};
  std::int64_t Steps = 1;
};

} // namespace

Result<OpenedVolume> OpenMrcVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto header, BinaryHeader::Open(files, name.Path, HeaderSize));
  MrcParser parser(header);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto raw, parser.TakeSamples(choice.Step));
  OpenedVolume volume;
  for (std::int64_t step = 0; parser.GetSteps() > 1 && step < parser.GetSteps(); ++step)
  {
    volume.Times.push_back(static_cast<double>(step));
  }
  if (choice.Step >= static_cast<std::uint64_t>(parser.GetSteps()))
  {
    return volume; // OpenForeignVolume knows what to say of it
  }
  auto source = raw.Open(files);
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  ValueType type = raw.Type;
  if (header.Get<std::int32_t>(Mode) == HalfMode)
  {
    *source = std::make_unique<ConvertedSource>(std::move(*source));
    type = ValueType::Float32;
  }
  if (parser.GetAxes() != std::array<std::size_t, 3>{ 0, 1, 2 })
  {
    *source = std::make_unique<PermutedSource>(std::move(*source), parser.GetAxes());
  }
  volume.Grid = parser.FindGrid();
  if (parser.IsStackOfImages())
  {
    AddNote(
      volume.LeftOut, "its sections are images that are no slices of a volume (space group 0)");
  }
  const std::uint64_t later =
    *raw.CountBytes() * (static_cast<std::uint64_t>(parser.GetSteps()) - choice.Step - 1);
  if (const std::string surplus = raw.DescribeSurplus(files, later); !surplus.empty())
  {
    AddNote(volume.LeftOut, surplus);
  }
  volume.Arrays = { { "MRC", type, 1 } };
  volume.Source = std::move(*source);
  return volume;
}

} // namespace isosurface
