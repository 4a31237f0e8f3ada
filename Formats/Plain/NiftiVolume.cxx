// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/NiftiVolume.h"

#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/BinaryHeader.h"
#include "Formats/Source/ConvertedSource.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t FirstSize = 348;
constexpr std::size_t SecondSize = 540;
constexpr std::pair<int, ValueType> Types[] = { { 2, ValueType::UInt8 }, { 4, ValueType::Int16 },
  { 8, ValueType::Int32 }, { 16, ValueType::Float32 }, { 64, ValueType::Float64 },
  { 256, ValueType::Int8 }, { 512, ValueType::UInt16 }, { 768, ValueType::UInt32 },
  { 1024, ValueType::Int64 }, { 1280, ValueType::UInt64 } };

/// The fields of both versions of the header.
struct NiftiFields
{
  std::array<std::int64_t, 8> Dimensions{};
  std::array<double, 8> Distances{}; ///< "pixdim"
  int Type = 0;
  double Offset = 0;
  SampleScale Scale;
  double FirstTime = 0;
  int QformCode = 0;
  int SformCode = 0;
  std::array<double, 3> Quaternion{};
  std::array<double, 3> QuaternionOffset{};
  std::array<std::array<double, 4>, 3> Rows{}; ///< of the sform
};

template <typename Real, typename Size, typename Code>
NiftiFields TakeFields(const BinaryHeader& header, const std::array<std::size_t, 10>& at)
{
  NiftiFields fields;
  for (std::size_t axis = 0; axis < 8; ++axis)
  {
    fields.Dimensions[axis] = header.Get<Size>(at[0] + axis * sizeof(Size));
    fields.Distances[axis] = header.Get<Real>(at[1] + axis * sizeof(Real));
  }
  fields.Type = header.Get<std::int16_t>(at[2]);
  fields.Scale = { header.Get<Real>(at[4]), header.Get<Real>(at[4] + sizeof(Real)) };
  fields.FirstTime = header.Get<Real>(at[5]);
  fields.QformCode = header.Get<Code>(at[6]);
  fields.SformCode = header.Get<Code>(at[6] + sizeof(Code));
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    fields.Quaternion[axis] = header.Get<Real>(at[7] + axis * sizeof(Real));
    fields.QuaternionOffset[axis] = header.Get<Real>(at[8] + axis * sizeof(Real));
    for (std::size_t column = 0; column < 4; ++column)
    {
      fields.Rows[axis][column] = header.Get<Real>(at[9] + (4 * axis + column) * sizeof(Real));
    }
  }
  return fields;
}

NiftiFields TakeFirstFields(const BinaryHeader& header)
{
  auto fields = TakeFields<float, std::int16_t, std::int16_t>(
    header, { 40, 76, 70, 108, 112, 136, 252, 256, 268, 280 });
  fields.Offset = header.Get<float>(108);
  return fields;
}

NiftiFields TakeSecondFields(const BinaryHeader& header)
{
  auto fields = TakeFields<double, std::int64_t, std::int32_t>(
    header, { 16, 104, 12, 168, 176, 216, 344, 352, 376, 400 });
  fields.Offset = static_cast<double>(header.Get<std::int64_t>(168));
  return fields;
}

/// Sets spacing and direction to the lengths and directions of the columns of a matrix.
void TakeMatrix(const std::array<std::array<double, 3>, 3>& rows, GridGeometry& grid)
{
  for (std::size_t column = 0; column < 3; ++column)
  {
    const double length = std::sqrt(rows[0][column] * rows[0][column] +
      rows[1][column] * rows[1][column] + rows[2][column] * rows[2][column]);
    grid.Spacing[column] = length;
    for (std::size_t row = 0; row < 3; ++row)
    {
      // Without negative zeros.
      grid.Direction[3 * row + column] = length > 0 ? rows[row][column] / length + 0.0 : 0;
    }
  }
}

/// Method 2 of the specification: a rotation by a quaternion, and perhaps a mirror.
void TakeQuaternion(const NiftiFields& fields, GridGeometry& grid)
{
  auto [b, c, d] = fields.Quaternion;
  const double square = 1 - (b * b + c * c + d * d);
  double a = std::sqrt(std::max(0.0, square));
  if (square < 1e-7)
  {
    // A turn by half a circle, with rounding errors.
    const double norm = std::sqrt(b * b + c * c + d * d);
    b /= norm;
    c /= norm;
    d /= norm;
    a = 0;
  }
  const double mirror = fields.Distances[0] < 0 ? -1 : 1;
  grid.Direction = { a * a + b * b - c * c - d * d, 2 * (b * c - a * d),
    mirror * 2 * (b * d + a * c), 2 * (b * c + a * d), a * a + c * c - b * b - d * d,
    mirror * 2 * (c * d - a * b), 2 * (b * d - a * c), 2 * (c * d + a * b),
    mirror * (a * a + d * d - c * c - b * b) };
  for (double& value : grid.Direction)
  {
    value += 0.0; // without negative zeros
  }
  grid.Origin = fields.QuaternionOffset;
}

void TakePlace(const NiftiFields& fields, GridGeometry& grid)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double distance = std::abs(fields.Distances[axis + 1]);
    grid.Spacing[axis] = distance > 0 ? distance : 1;
  }
  if (fields.SformCode > 0)
  {
    std::array<std::array<double, 3>, 3> rows;
    for (std::size_t row = 0; row < 3; ++row)
    {
      std::copy_n(fields.Rows[row].begin(), 3, rows[row].begin());
      grid.Origin[row] = fields.Rows[row][3];
    }
    TakeMatrix(rows, grid);
  }
  else if (fields.QformCode > 0)
  {
    TakeQuaternion(fields, grid);
  }
}

Result<BinaryHeader> OpenHeader(FileSystem& files, const std::string& path, bool& isSecond)
{
  auto header = BinaryHeader::Open(files, path, FirstSize);
  ISOSURFACE_RETURN_IF_ERROR(header.GetStatus());
  for (const bool isBigEndian : { false, true })
  {
    header->SetBigEndian(isBigEndian);
    const auto size = header->Get<std::int32_t>(0);
    isSecond = size == SecondSize;
    if (isSecond && header->HasText(4, "n+2"))
    {
      header = BinaryHeader::Open(files, path, SecondSize);
      if (header.IsOk())
      {
        header->SetBigEndian(isBigEndian);
      }
      return header;
    }
    if (size == FirstSize && header->HasText(344, "n+1"))
    {
      return header;
    }
  }
  return header->MakeError(StatusCode::Corrupt, "it is not a single file of NIfTI");
}

/// Fills in the grid, type and place of the samples of a time step.
Status TakeVolume(
  const BinaryHeader& header, const NiftiFields& fields, std::size_t step, RawVolume& raw)
{
  const std::int64_t rank = fields.Dimensions[0];
  if (rank < 1 || rank > 7)
  {
    return header.MakeError(StatusCode::Corrupt, "its number of axes is impossible");
  }
  raw.Grid.Extent = {};
  double stepBytes = 1;
  for (std::size_t axis = 1; axis <= static_cast<std::size_t>(rank); ++axis)
  {
    const std::int64_t size = fields.Dimensions[axis];
    if (size < 1 || size > (std::int64_t{ 1 } << 31))
    {
      return header.MakeError(StatusCode::Corrupt, "it has an impossible number of samples");
    }
    if (axis > 4 && size > 1)
    {
      return header.MakeError(StatusCode::Unsupported,
        "it has " + std::to_string(size) + " samples on its axis number " + std::to_string(axis));
    }
    if (axis <= 3)
    {
      raw.Grid.Extent[2 * axis - 1] = size - 1;
      stepBytes *= static_cast<double>(size);
    }
  }
  const auto* const type = std::find_if(std::begin(Types), std::end(Types),
    [&fields](const auto& known) { return known.first == fields.Type; });
  if (type == std::end(Types))
  {
    return header.MakeError(StatusCode::Unsupported,
      "its data type " + std::to_string(fields.Type) + " is not one of real numbers");
  }
  raw.Type = type->second;
  stepBytes *= static_cast<double>(GetValueSize(raw.Type));
  const double offset = fields.Offset + stepBytes * static_cast<double>(step);
  if (!(fields.Offset >= static_cast<double>(FirstSize)) || !(offset + stepBytes < 0x1p53))
  {
    return header.MakeError(StatusCode::Corrupt, "the place of its samples is impossible");
  }
  (header.IsGzip() ? raw.Skip : raw.Offset) = static_cast<std::uint64_t>(offset);
  return Status::Ok();
}

} // namespace

Result<OpenedVolume> OpenNiftiVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  bool isSecond = false;
  const auto header = OpenHeader(files, name.Path, isSecond);
  ISOSURFACE_RETURN_IF_ERROR(header.GetStatus());
  const NiftiFields fields = isSecond ? TakeSecondFields(*header) : TakeFirstFields(*header);
  RawVolume raw;
  raw.IsBigEndian = header->IsBigEndian();
  raw.IsGzip = header->IsGzip();
  raw.Paths = { name.Path };
  ISOSURFACE_RETURN_IF_ERROR(TakeVolume(*header, fields, choice.Step, raw));
  TakePlace(fields, raw.Grid);
  OpenedVolume volume;
  if (fields.Dimensions[0] >= 4 && fields.Dimensions[4] > 1)
  {
    if (fields.Dimensions[4] > MaximumTimeSteps)
    {
      return header->MakeError(StatusCode::Unsupported, "it has too many time steps");
    }
    const double distance = fields.Distances[4] > 0 ? fields.Distances[4] : 1;
    for (std::int64_t step = 0; step < fields.Dimensions[4]; ++step)
    {
      volume.Times.push_back(fields.FirstTime + distance * static_cast<double>(step));
    }
  }
  if (choice.Step >= std::max<std::size_t>(1, volume.Times.size()))
  {
    return volume; // of which OpenedVolume knows what to say
  }
  auto source = raw.Open(files);
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  const bool isScaled = fields.Scale.Slope != 0 && std::isfinite(fields.Scale.Slope) &&
    std::isfinite(fields.Scale.Intercept) && !fields.Scale.IsIdentity();
  const ValueType type = isScaled ? FindScaledType(raw.Type) : raw.Type;
  if (isScaled)
  {
    *source = std::make_unique<ConvertedSource>(std::move(*source), raw.Type, fields.Scale, type);
  }
  volume.Grid = raw.Grid;
  volume.Arrays = { { "NIFTI", type, 1 } };
  volume.Source = std::move(*source);
  return volume;
}

} // namespace isosurface
