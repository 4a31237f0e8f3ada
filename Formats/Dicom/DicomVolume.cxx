// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomVolume.h"

#include "Formats/Dicom/DicomSlice.h"
#include "Ground/Volume/PageBuffer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

using Slices = std::vector<DicomSlice>;

constexpr const char* NoImages = "there are no images of DICOM";

Status MakeError(StatusCode code, const DicomSlice& slice, const std::string& reason)
{
  return Status(code, slice.Path + ": cannot be read: " + reason);
}

/// Boxes of the slices' images, decoded one after another.
class DicomSource : public BoxSource
{
public:
  DicomSource(std::shared_ptr<const Slices> slices, ValueType type)
    : Series(std::move(slices))
    , Type(type)
    , Box{ { 0, 0, 0 },
      { this->Series->front().Columns, this->Series->front().Rows,
        static_cast<std::int64_t>(this->Series->size()) } }
    , Pool(std::make_shared<PageBufferPool>())
  {
  }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    return static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Type);
  }
  /// A compressed image and a copy that GDCM makes, the decoded one and another copy; less of others.
  std::uint64_t GetHeldBytes() const override
  {
    return 6 * static_cast<std::uint64_t>(this->Box.High[0] * this->Box.High[1]) *
      GetValueSize(this->Series->front().Type) +
      this->Series->size() * 1024;
  }
  /// An image.
  std::optional<Index3> GetChunk() const override
  {
    return Index3{ this->Box.High[0], this->Box.High[1], 1 };
  }

  bool DecodesInParallel() const override { return true; }
  std::unique_ptr<BoxSource> Fork() const override
  {
    return std::make_unique<DicomSource>(this->Series, this->Type);
  }

  Result<BoxSamples> Read(const VertexBox& box) override
  {
    auto samples = this->Pool->Take(this->GetReadBytes(box));
    ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
    const Index3 size = box.GetSize();
    const std::int64_t width = this->Box.High[0];
    std::uint8_t* to = (*samples)->GetData();
    for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
    {
      const DicomSlice& slice = (*this->Series)[static_cast<std::size_t>(k)];
      ISOSURFACE_RETURN_IF_ERROR(slice.Decode(this->Image));
      for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
      {
        const auto first =
          static_cast<std::size_t>(j * width + box.Low[0]) * GetValueSize(slice.Type);
        ScaleSamples(slice.Type, this->Image.data() + first, static_cast<std::size_t>(size[0]),
          slice.Scale, this->Type, to);
        to += static_cast<std::size_t>(size[0]) * GetValueSize(this->Type);
      }
    }
    return MakeBoxSamples(this->Type, box, std::move(*samples));
  }

private:
  std::shared_ptr<const Slices> Series;
  ValueType Type;
  VertexBox Box;
  std::vector<std::uint8_t> Image;
  std::shared_ptr<PageBufferPool> Pool;
};

/// Whether there is a folder; not if the system does not tell.
bool IsFolder(const std::string& path)
{
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

std::string FindFolder(const std::string& path)
{
  if (IsFolder(path))
  {
    return path;
  }
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  return parent.empty() ? "." : parent.string();
}

/// What a folder has of a series.
struct FoundSeries
{
  Slices Found;
  Status Fault; ///< of the first of its images that cannot be read
};

/// All series in a folder, by their UID. An image that cannot be read is an error of its series; of all
/// if its header does not tell the series, since a slice of any may be missing.
Result<std::map<std::string, FoundSeries>> FindSeries(const std::string& folder)
{
  const auto names = GetLocalFileSystem().List(folder);
  ISOSURFACE_RETURN_IF_ERROR(names.GetStatus());
  std::map<std::string, FoundSeries> series;
  for (const std::string& name : *names)
  {
    const std::string path = (std::filesystem::path(folder) / name).string();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
    {
      continue;
    }
    std::string uid;
    auto slice = DicomSlice::Read(path, &uid);
    if (slice.IsOk())
    {
      series[uid].Found.push_back(std::move(*slice));
    }
    else if (slice.GetStatus().GetCode() != StatusCode::NotFound)
    {
      if (uid.empty())
      {
        return slice.GetStatus();
      }
      Status& fault = series[uid].Fault;
      fault = fault.IsOk() ? slice.GetStatus() : fault;
    }
  }
  return series;
}

Result<Slices> ChooseSeries(const VolumeName& name)
{
  auto all = FindSeries(FindFolder(name.Path));
  ISOSURFACE_RETURN_IF_ERROR(all.GetStatus());
  std::string wanted = name.Within;
  if (!IsFolder(name.Path))
  {
    const auto slice = DicomSlice::Read(name.Path);
    ISOSURFACE_RETURN_IF_ERROR(slice.GetStatus());
    wanted = slice->Series;
  }
  const auto take = [](FoundSeries& series) -> Result<Slices>
  {
    ISOSURFACE_RETURN_IF_ERROR(series.Fault);
    return std::move(series.Found);
  };
  std::vector<FoundSeries*> fitting;
  Status fault;
  std::string known;
  for (auto& [uid, series] : *all)
  {
    if (uid == wanted)
    {
      return take(series);
    }
    const Slices& slices = series.Found;
    const bool isEnd = uid.size() >= wanted.size() &&
      uid.compare(uid.size() - wanted.size(), wanted.size(), wanted) == 0;
    if (isEnd && slices.empty())
    {
      fault = fault.IsOk() ? series.Fault : fault;
    }
    else if (isEnd)
    {
      fitting.push_back(&series);
    }
    if (!slices.empty())
    {
      known += (known.empty() ? "" : ", ") + uid + " (" + std::to_string(slices.size()) +
        " slices, \"" + slices[0].Description + "\")";
    }
  }
  if (fitting.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(fault);
  }
  if (fitting.size() != 1)
  {
    return Status(StatusCode::NotFound,
      name.GetText() + ": cannot be read: " +
        (known.empty() ? NoImages
                       : "name one of its series, as in " + name.Path + ":UID: " + known));
  }
  return take(*fitting[0]);
}

/// Checks that the slices are images of one kind, and sorts them.
Status SortSlices(Slices& slices)
{
  const DicomSlice& first = slices[0];
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
    if (slice.Rows != first.Rows || slice.Columns != first.Columns || slice.Type != first.Type)
    {
      return MakeError(
        StatusCode::Unsupported, slice, "its size or type differs from that of " + first.Path);
    }
    const auto differs = [](const Vector3& a, const Vector3& b)
    { return !(std::abs(Dot(a, b) - 1) < 1e-3); };
    if (!slice.HasPlace || differs(slice.AlongRow, first.AlongRow) ||
      differs(slice.AlongColumn, first.AlongColumn))
    {
      return MakeError(StatusCode::Unsupported, slice,
        slice.HasPlace ? "its orientation differs from that of " + first.Path
                       : std::string("it has no position or orientation"));
    }
  }
  const Vector3 normal = Cross(first.AlongRow, first.AlongColumn);
  std::stable_sort(slices.begin(), slices.end(),
    [&normal](const DicomSlice& a, const DicomSlice& b)
    { return Dot(a.Position, normal) < Dot(b.Position, normal); });
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

/// Sets the grid from slices in their order. Says how far a gantry is tilted.
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
    const Vector3 moved = Subtract(slices[slice].Position, slices[slice - 1].Position);
    if (!(Dot(moved, normal) > 1e-6))
    {
      return MakeError(StatusCode::Unsupported, slices[slice],
        "it lies where " + slices[slice - 1].Path + " does; are there several times or echoes?");
    }
    if (!IsInStep(slices, slice, step, distance, uncertainty))
    {
      return MakeError(StatusCode::Unsupported, slices[slice],
        "its distance to " + slices[slice - 1].Path + " is " + std::to_string(Dot(moved, normal)) +
          ", that of the others " + std::to_string(distance) +
          " on average: a slice is missing, or their distances differ");
    }
  }
  GridGeometry& grid = volume.Grid;
  grid.Extent = { 0, first.Columns - 1, 0, first.Rows - 1, 0, count - 1 };
  grid.Origin = first.Position;
  grid.Spacing = { first.ColumnDistance, first.RowDistance,
    ShortenDistance(distance, slices.size() - 1, uncertainty) };
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
  return Status::Ok();
}

/// The smallest type that has all scaled values.
ValueType FindType(const Slices& slices)
{
  double low = 0;
  double high = 0;
  bool isScaled = false;
  for (const DicomSlice& slice : slices)
  {
    const auto [slope, intercept] = slice.Scale;
    isScaled = isScaled || !slice.Scale.IsIdentity();
    if (slope != std::floor(slope) || intercept != std::floor(intercept))
    {
      return ValueType::Float32;
    }
    const bool isSigned = slice.Type == ValueType::Int8 || slice.Type == ValueType::Int16 ||
      slice.Type == ValueType::Int32;
    const double range = std::ldexp(1.0, slice.ValueBits);
    const double minimum = isSigned ? -range / 2 : 0;
    const double ends[] = { slope * minimum + intercept,
      slope * (minimum + range - 1) + intercept };
    low = std::min({ low, ends[0], ends[1] });
    high = std::max({ high, ends[0], ends[1] });
  }
  if (!isScaled)
  {
    return slices[0].Type;
  }
  return low >= -128 && high <= 127              ? ValueType::Int8
    : low >= 0 && high <= 255                    ? ValueType::UInt8
    : low >= -32768 && high <= 32767             ? ValueType::Int16
    : low >= 0 && high <= 65535                  ? ValueType::UInt16
    : low >= -2147483648.0 && high <= 2147483647 ? ValueType::Int32
                                                 : ValueType::Float64;
}

Result<OpenedVolume> OpenDicomVolume(
  FileSystem& /*files*/, const VolumeName& name, const VolumeChoice& /*choice*/)
{
  auto slices = ChooseSeries(name);
  ISOSURFACE_RETURN_IF_ERROR(slices.GetStatus());
  ISOSURFACE_RETURN_IF_ERROR(SortSlices(*slices));
  OpenedVolume volume;
  ISOSURFACE_RETURN_IF_ERROR(TakeGrid(*slices, volume));
  const ValueType type = FindType(*slices);
  const bool isHounsfield = std::all_of(
    slices->begin(), slices->end(), [](const DicomSlice& slice) { return slice.IsHounsfield; });
  volume.Arrays = { { "DICOM", type, 1, isHounsfield ? "HU" : "" } };
  for (const DicomSlice& slice : *slices)
  {
    volume.Files.push_back(slice.Path);
  }
  volume.Source =
    std::make_unique<DicomSource>(std::make_shared<const Slices>(std::move(*slices)), type);
  return volume;
}

Result<std::vector<VolumeListing>> ListDicom(FileSystem& /*files*/, const VolumeName& name)
{
  const auto all = FindSeries(FindFolder(name.Path));
  ISOSURFACE_RETURN_IF_ERROR(all.GetStatus());
  if (all->empty())
  {
    return Status(StatusCode::NotFound, name.GetText() + ": cannot be read: " + NoImages);
  }
  std::vector<VolumeListing> list;
  for (const auto& [uid, series] : *all)
  {
    if (!series.Fault.IsOk())
    {
      list.push_back({ uid, "?", "?", series.Fault.GetMessage() });
      continue;
    }
    const Slices& slices = series.Found;
    list.push_back({ uid,
      std::to_string(slices.size()) + " x " + std::to_string(slices[0].Rows) + " x " +
        std::to_string(slices[0].Columns),
      GetValueTypeName(slices[0].Type),
      "\"" + slices[0].Description + "\", transfer syntax " + slices[0].Syntax });
  }
  return list;
}

} // namespace

const FormatFunctions IsosurfaceDicomFormat = { OpenDicomVolume, ListDicom };

} // namespace isosurface
