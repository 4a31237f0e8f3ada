// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomStack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

using Slices = std::vector<DicomSlice>;

Status MakeError(StatusCode code, const DicomSlice& slice, const std::string& reason)
{
  return Status(code, slice.Path + ": cannot be read: " + reason);
}

bool HaveSameDirections(const DicomSlice& a, const DicomSlice& b)
{
  return a.HasPlace && b.HasPlace && std::abs(Dot(a.AlongRow, b.AlongRow) - 1) < 1e-3 &&
    std::abs(Dot(a.AlongColumn, b.AlongColumn) - 1) < 1e-3;
}

bool IsLocalizer(const DicomSlice& slice)
{
  return slice.ImageType.find("LOCALIZER") != std::string::npos;
}

template <typename IsLeftOut>
void LeaveOut(Slices& slices, const std::string& reason, PassedOver& over, IsLeftOut&& isLeftOut)
{
  const auto end = std::stable_partition(
    slices.begin(), slices.end(), [&](const DicomSlice& slice) { return !isLeftOut(slice); });
  for (auto slice = end; slice != slices.end(); ++slice)
  {
    over.Add(reason, slice->Path);
  }
  slices.erase(end, slices.end());
}

void LeaveOutScouts(Slices& slices, PassedOver& over)
{
  if (!std::all_of(slices.begin(), slices.end(), IsLocalizer))
  {
    LeaveOut(slices, "of a scout", over, IsLocalizer);
  }
  for (const DicomSlice& slice : slices)
  {
    const auto alike = std::count_if(slices.begin(), slices.end(),
      [&slice](const DicomSlice& other) { return HaveSameDirections(slice, other); });
    if (2 * static_cast<std::size_t>(alike) > slices.size())
    {
      const DicomSlice most = slice;
      LeaveOut(slices, "of another orientation", over,
        [&most](const DicomSlice& other)
        { return other.HasPlace && !HaveSameDirections(most, other); });
      return;
    }
    if (&slice - slices.data() > 64)
    {
      return; // no orientation that most of them have is so rare at the start
    }
  }
}

/// Checks that the slices are images of one kind.
Status CheckKind(const Slices& slices)
{
  const DicomSlice& first = slices[0];
  const auto differs = [](double a, double b) { return !(std::abs(a - b) <= 1e-4 * a); };
  for (const DicomSlice& slice : slices)
  {
    if (slice.Channels != 1 || slice.Photometric.compare(0, 10, "MONOCHROME") != 0)
    {
      return MakeError(StatusCode::Unsupported, slice,
        "its pixels are colours (" + slice.Photometric + "), not samples");
    }
    if (slice.Frames != 1)
    {
      return MakeError(StatusCode::Unsupported, slice,
        "it has " + std::to_string(slice.Frames) + " frames; series with a slice a file are read");
    }
    if (slice.ImageType.find("MOSAIC") != std::string::npos)
    {
      return MakeError(StatusCode::Unsupported, slice,
        "its image is a mosaic of slices; series with a slice a file are read");
    }
    if (slice.Rows != first.Rows || slice.Columns != first.Columns)
    {
      return MakeError(
        StatusCode::Unsupported, slice, "its size differs from that of " + first.Path);
    }
    if (!HaveSameDirections(slice, first))
    {
      return MakeError(StatusCode::Unsupported, slice,
        !slice.HasPlace      ? "it has no position or orientation"
          : &slice == &first ? "its orientation is no two unit vectors"
                             : "its orientation differs from that of " + first.Path);
    }
    if (differs(first.RowDistance, slice.RowDistance) ||
      differs(first.ColumnDistance, slice.ColumnDistance))
    {
      return MakeError(
        StatusCode::Unsupported, slice, "its Pixel Spacing differs from that of " + first.Path);
    }
  }
  return std::abs(Dot(first.AlongRow, first.AlongColumn)) < 1e-3
    ? Status::Ok()
    : MakeError(StatusCode::Unsupported, first, "its rows and columns are not at right angles");
}

/// Whether both images have the same samples.
Result<bool> HaveSameSamples(const DicomSlice& a, const DicomSlice& b)
{
  if (a.Type != b.Type || a.Scale.Slope != b.Scale.Slope || a.Scale.Intercept != b.Scale.Intercept)
  {
    return false;
  }
  std::vector<std::uint8_t> samples;
  std::vector<std::uint8_t> others;
  ISOSURFACE_RETURN_IF_ERROR(a.Decode(samples));
  ISOSURFACE_RETURN_IF_ERROR(b.Decode(others));
  return samples == others;
}

/// In what two images of one place differ.
std::string FindDifference(const DicomSlice& slice, const DicomSlice& other)
{
  for (std::size_t moment = 0; moment < slice.Moments.size(); ++moment)
  {
    if (slice.Moments[moment] != other.Moments[moment])
    {
      return "has another " + std::string(DicomSlice::MomentNames[moment]) + " (" +
        slice.Moments[moment] + ", not " + other.Moments[moment] + ")";
    }
  }
  return "has other samples";
}

/// Of sorted slices, leaves out copies. Error: several images in one place.
Status LeaveOutCopies(Slices& slices, const Vector3& normal, PassedOver& over)
{
  std::size_t kept = 0;
  for (std::size_t slice = 1; slice < slices.size(); ++slice)
  {
    const Vector3 moved = Subtract(slices[slice].Position, slices[kept].Position);
    if (!(Dot(moved, normal) > 1e-6))
    {
      const DicomSlice& one = slices[kept];
      ISOSURFACE_ASSIGN_OR_RETURN(const auto areSame, HaveSameSamples(slices[slice], one));
      if (!areSame || !(Dot(moved, moved) <= 1e-12))
      {
        return MakeError(StatusCode::Unsupported, slices[slice],
          "it lies where " + one.Path + " does, and " + FindDifference(slices[slice], one) +
            "; series with one image in each place are read");
      }
      over.Add("copied", slices[slice].Path);
      continue;
    }
    ++kept;
    if (kept != slice)
    {
      slices[kept] = std::move(slices[slice]);
    }
  }
  slices.erase(slices.begin() + static_cast<std::ptrdiff_t>(kept) + 1, slices.end());
  return Status::Ok();
}

/// What the digits of two positions do not tell of the way from one to the other. Some write no zeros at
/// the end, so the number with the most decimals counts. Numbers that are float32, written with more
/// digits than that has ("-113.699997"), are no more exact than two steps of float32.
double FindUncertainty(const Slices& slices)
{
  double unit = std::numeric_limits<double>::max();
  float largest = 0;
  for (const DicomSlice& slice : slices)
  {
    unit = std::min(unit, slice.PositionUnit);
    for (const double number : slice.Position)
    {
      largest = std::max(largest, std::abs(static_cast<float>(number)));
    }
  }
  const bool isSingle = std::all_of(slices.begin(), slices.end(),
    [unit](const DicomSlice& slice)
    {
      return std::all_of(slice.Position.begin(), slice.Position.end(),
        [unit](double number)
        { return std::abs(static_cast<double>(static_cast<float>(number)) - number) <= unit / 2; });
    });
  constexpr double step = std::numeric_limits<float>::epsilon();
  // Half a unit of each of the three numbers, twice; and the rounding of this program.
  return std::sqrt(3.0) * (isSingle ? std::max(unit, 2 * step * largest) : unit) + 1e-13 * largest;
}

/// The distance of the fewest decimals with which the last slice lies where it does, as far as the
/// digits of its position tell: 1 in place of 0.9999999999999998.
double ShortenDistance(double distance, std::size_t steps, double uncertainty)
{
  double digits = 1;
  for (int decimals = 0; decimals <= 12; ++decimals)
  {
    const double shorter = std::round(distance * digits) / digits;
    if (std::abs(shorter - distance) * static_cast<double>(steps) <= uncertainty / 2)
    {
      return shorter;
    }
    digits *= 10;
  }
  return distance;
}

/// Whether slice after slice is where it should be, a step each from the first one on: to a hundredth
/// of the distance, or as far as the digits of the positions tell. A step that is missing is told.
bool IsInStep(
  const Slices& slices, std::size_t slice, const Vector3& step, double distance, double uncertainty)
{
  const auto findFault = [&](std::size_t from)
  {
    Vector3 fault = Subtract(slices[slice].Position, slices[from].Position);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      fault[axis] -= step[axis] * distance * static_cast<double>(slice - from);
    }
    return std::sqrt(Dot(fault, fault));
  };
  const double fault = findFault(slice - 1);
  return fault <= 0.01 * distance + 1e-3 ||
    (fault <= std::min(uncertainty, 0.4 * distance) && findFault(0) <= uncertainty);
}

/// Names the two slices whose distance differs most from the usual one.
Status MakeGapError(const Slices& slices, const Vector3& normal)
{
  const auto gap = [&](std::size_t slice)
  { return Dot(Subtract(slices[slice].Position, slices[slice - 1].Position), normal); };
  std::vector<double> gaps;
  for (std::size_t slice = 1; slice < slices.size(); ++slice)
  {
    gaps.push_back(gap(slice));
  }
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  const double usual = *middle;
  std::size_t worst = 1;
  for (std::size_t slice = 2; slice < slices.size(); ++slice)
  {
    worst = std::abs(gap(slice) - usual) > std::abs(gap(worst) - usual) ? slice : worst;
  }
  return MakeError(StatusCode::Unsupported, slices[worst],
    "its distance to " + slices[worst - 1].Path + " is " + std::to_string(gap(worst)) +
      ", that of most others " + std::to_string(usual) +
      ": a slice is missing, or their distances differ");
}

} // namespace

Status SortSlices(Slices& slices, PassedOver& over)
{
  LeaveOutScouts(slices, over);
  ISOSURFACE_RETURN_IF_ERROR(CheckKind(slices));
  const Vector3 normal = Cross(slices[0].AlongRow, slices[0].AlongColumn);
  std::stable_sort(slices.begin(), slices.end(),
    [&normal](const DicomSlice& a, const DicomSlice& b)
    { return Dot(a.Position, normal) < Dot(b.Position, normal); });
  return LeaveOutCopies(slices, normal, over);
}

Status TakeGrid(const Slices& slices, OpenedVolume& volume)
{
  const DicomSlice& first = slices.front();
  const auto count = static_cast<std::int64_t>(slices.size());
  const Vector3 normal = Cross(first.AlongRow, first.AlongColumn);
  const double uncertainty = FindUncertainty(slices);
  Vector3 step = normal;
  double distance = 1;
  if (count > 1)
  {
    step = Subtract(slices.back().Position, first.Position);
    distance = std::sqrt(Dot(step, step)) / static_cast<double>(count - 1);
    for (double& number : step)
    {
      number /= distance * static_cast<double>(count - 1);
    }
  }
  for (std::size_t slice = 1; slice < slices.size(); ++slice)
  {
    if (!IsInStep(slices, slice, step, distance, uncertainty))
    {
      return MakeGapError(slices, normal);
    }
  }
  GridGeometry& grid = volume.Grid;
  grid.Extent = { 0, first.Columns - 1, 0, first.Rows - 1, 0, count - 1 };
  grid.Origin = first.Position;
  grid.Spacing = { first.ColumnDistance, first.RowDistance,
    ShortenDistance(distance, slices.size() - 1, uncertainty) };
  grid.Unit = first.HasDistances ? LengthUnit::Millimeter : LengthUnit::Unknown;
  // By more than the digits may be wrong.
  const double aside = std::sqrt(std::max(0.0, 1 - Dot(step, normal) * Dot(step, normal))) *
    distance * static_cast<double>(count - 1);
  const bool isTilted = Dot(step, normal) < 1 - 1e-5 && aside > uncertainty;
  const Vector3 third = isTilted ? step : normal;
  for (std::size_t row = 0; row < 3; ++row)
  {
    grid.Direction[3 * row] = first.AlongRow[row];
    grid.Direction[3 * row + 1] = first.AlongColumn[row];
    grid.Direction[3 * row + 2] = third[row];
  }
  if (isTilted)
  {
    std::array<char, 120> text{};
    std::snprintf(text.data(), text.size(),
      "the gantry is tilted by %.1f degrees: the directions of the grid are not at right angles",
      std::acos(std::min(1.0, Dot(step, normal))) * 180 / 3.14159265358979323846);
    volume.LeftOut = text.data();
  }
  const double stated = first.SliceDistance;
  if (count > 1 && stated > 0 && std::abs(stated - Dot(step, normal) * distance) > 0.01 * stated)
  {
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(),
      "the slices are %.6g mm apart by their positions, %.6g by Spacing Between Slices: their "
      "positions count",
      Dot(step, normal) * distance, stated);
    volume.LeftOut += (volume.LeftOut.empty() ? "" : "; ") + std::string(text.data());
  }
  return Status::Ok();
}

} // namespace isosurface
