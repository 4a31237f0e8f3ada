// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/PlainFormats.h"

#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/BinaryHeader.h"
#include "Formats/Source/ConvertedSource.h"
#include "Formats/Source/FolderFiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t FirstSize = 348;
constexpr std::size_t SecondSize = 540;
/// Where samples begin if the header tells 0: behind it, and four bytes that tell of extensions.
constexpr std::size_t ExtensionBytes = 4;
constexpr std::pair<int, ValueType> Types[] = { { 2, ValueType::UInt8 }, { 4, ValueType::Int16 },
  { 8, ValueType::Int32 }, { 16, ValueType::Float32 }, { 64, ValueType::Float64 },
  { 130, ValueType::Int8 }, { 132, ValueType::UInt16 }, { 136, ValueType::UInt32 }, // of SPM 99
  { 256, ValueType::Int8 }, { 512, ValueType::UInt16 }, { 768, ValueType::UInt32 },
  { 1024, ValueType::Int64 }, { 1280, ValueType::UInt64 } };

constexpr std::pair<int, const char*> OtherTypes[] = { { 1, "bits" }, { 32, "complex64" },
  { 128, "RGB" }, { 1536, "float128" }, { 1792, "complex128" }, { 2048, "complex256" },
  { 2304, "RGBA" } };

enum class NiftiKind
{
  First,
  Second,
  Analyze ///< Analyze 7.5, of which NIfTI-1 was made
};

/// The fields of all kinds of the header.
struct NiftiFields
{
  std::array<std::int64_t, 8> Dimensions{};
  std::array<double, 8> Distances{}; ///< "pixdim"
  int Type = 0;
  double Offset = 0;
  int Units = 0; ///< "xyzt_units"
  std::string Told;
  int Intent = 0;
  bool IsPair = false; ///< whether the samples are in a file of their own, from Offset on
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
  fields.Units = header.Get<std::uint8_t>(123);
  fields.Intent = header.Get<std::int16_t>(68);
  fields.IsPair = header.HasText(344, "ni1");
  return fields;
}

NiftiFields TakeSecondFields(const BinaryHeader& header)
{
  auto fields = TakeFields<double, std::int64_t, std::int32_t>(
    header, { 16, 104, 12, 168, 176, 216, 344, 352, 376, 400 });
  fields.Offset = static_cast<double>(header.Get<std::int64_t>(168));
  fields.Units = header.Get<std::int32_t>(500);
  fields.Intent = header.Get<std::int32_t>(504);
  fields.IsPair = header.HasText(4, "ni2");
  return fields;
}

/// As SPM and nibabel take them: x runs to the left; a factor, an offset and the number of the sample at
/// the origin (from 1) are in fields that Analyze itself does not use.
NiftiFields TakeAnalyzeFields(FileSystem& files, const BinaryHeader& header)
{
  NiftiFields fields = TakeFirstFields(header);
  fields.IsPair = true;
  fields.FirstTime = 0;
  fields.QformCode = 0;
  fields.SformCode = 1;
  fields.Units = header.HasText(56, "mm") ? 2 : 0;
  fields.Rows = {};
  bool hasOrigin = false;
  bool isNear = true;
  std::array<double, 3> origin{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto size = static_cast<double>(fields.Dimensions[axis + 1]);
    origin[axis] = header.Get<std::int16_t>(253 + 2 * axis);
    hasOrigin = hasOrigin || origin[axis] != 0;
    isNear = isNear && origin[axis] > -size && origin[axis] < 2 * size;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double distance = std::abs(fields.Distances[axis + 1]);
    const double step = (axis == 0 ? -1 : 1) * (distance > 0 ? distance : 1);
    const auto last =
      static_cast<double>(std::max<std::int64_t>(fields.Dimensions[axis + 1], 1) - 1);
    fields.Rows[axis][axis] = step;
    fields.Rows[axis][3] = -step * (hasOrigin && isNear ? origin[axis] - 1 : last / 2) + 0.0;
  }
  AddNote(fields.Told,
    std::string("Analyze 7.5, as SPM takes it: x runs to the left, the origin is ") +
      (hasOrigin && isNear ? "the sample that its header names" : "the middle"));
  const double slope = fields.Scale.Slope;
  const double lowest = header.Get<std::int32_t>(144);
  const double values = header.Get<std::int32_t>(140) - lowest;
  const double least = header.Get<float>(128);
  const double range = header.Get<float>(124) - least;
  if (slope != 0 && std::isfinite(slope))
  {
    const double offset = fields.Scale.Intercept;
    fields.Scale.Intercept = std::isfinite(offset) ? offset : 0;
  }
  else if (values != 0 && range != 0 && std::isfinite(range))
  {
    fields.Scale = { range / values, least - range / values * lowest };
    AddNote(fields.Told, "its samples are scaled so that glmin to glmax become cal_min to cal_max");
  }
  if (fields.Units == 0 && header.Get<std::uint8_t>(56) != 0)
  {
    AddNote(fields.Told, "its unit of lengths (vox_units) is not kept");
  }
  if (header.Get<std::uint8_t>(252) != 0)
  {
    AddNote(fields.Told, "its orientation (orient) is not used");
  }
  const std::string matrix =
    std::filesystem::path(header.GetPath()).replace_extension(".mat").string();
  if (files.Exists(matrix))
  {
    AddNote(fields.Told, matrix + ", the place by SPM, is not read");
  }
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

/// Spacing, direction, origin, unit. What they are not of is told.
void TakePlace(const NiftiFields& fields, GridGeometry& grid, std::string& told)
{
  constexpr LengthUnit units[] = { LengthUnit::Unknown, LengthUnit::Meter, LengthUnit::Millimeter,
    LengthUnit::Micrometer };
  const int unit = fields.Units & 7;
  grid.Unit = unit < 4 ? units[unit] : LengthUnit::Unknown;
  const bool isEmpty = std::all_of(fields.Rows.begin(), fields.Rows.end(),
    [](const auto& row) { return std::count(row.begin(), row.begin() + 3, 0.0) == 3; });
  if (fields.SformCode > 0 && isEmpty)
  {
    AddNote(told,
      std::string("its sform is all zeros: it is placed by its ") +
        (fields.QformCode > 0 ? "qform" : "distances of samples alone"));
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double distance = std::abs(fields.Distances[axis + 1]);
    grid.Spacing[axis] = distance > 0 ? distance : 1;
  }
  if (fields.SformCode > 0 && !isEmpty)
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

Result<BinaryHeader> OpenHeader(FileSystem& files, const std::string& path, NiftiKind& kind)
{
  auto header = BinaryHeader::Open(files, path, FirstSize);
  ISOSURFACE_RETURN_IF_ERROR(header.GetStatus());
  for (const bool isBigEndian : { false, true })
  {
    header->SetBigEndian(isBigEndian);
    const auto size = header->Get<std::int32_t>(0);
    if (size == SecondSize && (header->HasText(4, "n+2") || header->HasText(4, "ni2")))
    {
      kind = NiftiKind::Second;
      header = BinaryHeader::Open(files, path, SecondSize);
      if (header.IsOk())
      {
        header->SetBigEndian(isBigEndian);
      }
      return header;
    }
    const bool isNifti = header->HasText(344, "n+1") || header->HasText(344, "ni1");
    if (size == FirstSize && (isNifti || FindExtension(path) == ".hdr"))
    {
      kind = isNifti ? NiftiKind::First : NiftiKind::Analyze;
      return header;
    }
  }
  return header->MakeError(StatusCode::Corrupt, "it is not a file of NIfTI");
}

/// Why a data type is not read.
Status MakeTypeError(const BinaryHeader& header, int type)
{
  const auto* const other = std::find_if(std::begin(OtherTypes), std::end(OtherTypes),
    [type](const auto& known) { return known.first == type; });
  return header.MakeError(StatusCode::Unsupported,
    "its data type " + std::to_string(type) +
      (other == std::end(OtherTypes) ? std::string() : std::string(", ") + other->second + ",") +
      " is not one of real numbers");
}

/// Where the samples of the first step begin. Nothing if they cannot be there.
std::optional<double> FindStart(const NiftiFields& fields, bool isSecond)
{
  const double header = static_cast<double>(isSecond ? SecondSize : FirstSize);
  if (fields.IsPair)
  {
    return fields.Offset >= 0 ? std::optional(fields.Offset) : std::nullopt;
  }
  const double start = fields.Offset == 0 ? header + ExtensionBytes : fields.Offset;
  return start >= header ? std::optional(start) : std::nullopt;
}

/// Fills in the grid, type and place of the samples of a time step, of the samples from `start` on.
Status TakeVolume(const BinaryHeader& header, const NiftiFields& fields,
  std::optional<double> start, std::size_t step, RawVolume& raw)
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
    // Some writers tell 0 of an axis that they do not have.
    const std::int64_t size = fields.Dimensions[axis] == 0 ? 1 : fields.Dimensions[axis];
    if (size < 1 || size > (std::int64_t{ 1 } << 31))
    {
      return header.MakeError(StatusCode::Corrupt, "it has an impossible number of samples");
    }
    if (axis > 4 && size > 1)
    {
      return header.MakeError(StatusCode::Unsupported,
        "it has " + std::to_string(size) + " samples on its axis number " + std::to_string(axis) +
          (axis == 5 ? ": components of a vector or a tensor (intent code " +
                std::to_string(fields.Intent) + ")"
                     : std::string()));
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
    return MakeTypeError(header, fields.Type);
  }
  raw.Type = type->second;
  stepBytes *= static_cast<double>(GetValueSize(raw.Type));
  const double offset = start.value_or(0) + stepBytes * static_cast<double>(step);
  if (!start || !(offset + stepBytes < 0x1p53))
  {
    return header.MakeError(StatusCode::Corrupt, "the place of its samples is impossible");
  }
  (raw.IsGzip ? raw.Skip : raw.Offset) = static_cast<std::uint64_t>(offset);
  return Status::Ok();
}

/// The file of the samples of a pair: the header's with another extension.
std::string FindImage(FileSystem& files, const std::string& path)
{
  std::filesystem::path image(path);
  image = image.extension() == ".gz" ? image.replace_extension() : image;
  image.replace_extension(".img");
  const std::string packed = image.string() + ".gz";
  return files.Exists(image.string()) || !files.Exists(packed) ? image.string() : packed;
}

/// The fourth axis: its places, and their unit, unless it is the second.
void TakeTimes(const NiftiFields& fields, OpenedVolume& volume)
{
  const double distance = fields.Distances[4] > 0 ? fields.Distances[4] : 1;
  for (std::int64_t step = 0; step < fields.Dimensions[4]; ++step)
  {
    volume.Times.push_back(fields.FirstTime + distance * static_cast<double>(step));
  }
  constexpr const char* units[] = { "", "", "ms", "us", "Hz", "ppm", "rad/s" };
  const int unit = (fields.Units & 0x38) >> 3;
  if (unit >= 2 && unit < 7)
  {
    AddNote(volume.LeftOut, std::string("its time steps are in ") + units[unit]);
  }
}

} // namespace

std::string FindNiftiHeader(const std::string& path)
{
  return FindExtension(path) == ".img"
    ? std::filesystem::path(path).replace_extension(".hdr").string()
    : path;
}

Result<OpenedVolume> OpenNiftiVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice)
{
  NiftiKind kind = NiftiKind::First;
  const std::string path = FindNiftiHeader(name.Path);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto header, OpenHeader(files, path, kind));
  const bool isSecond = kind == NiftiKind::Second;
  const NiftiFields fields = isSecond ? TakeSecondFields(header)
    : kind == NiftiKind::Analyze      ? TakeAnalyzeFields(files, header)
                                      : TakeFirstFields(header);
  RawVolume raw;
  raw.IsBigEndian = header.IsBigEndian();
  raw.IsGzip = header.IsGzip();
  raw.Paths = { path };
  if (fields.IsPair)
  {
    raw.Paths = { FindImage(files, path) };
    raw.IsGzip = FindExtension(raw.Paths.front()) == ".img.gz";
  }
  ISOSURFACE_RETURN_IF_ERROR(
    TakeVolume(header, fields, FindStart(fields, isSecond), choice.Step, raw));
  OpenedVolume volume;
  volume.LeftOut = fields.Told;
  TakePlace(fields, raw.Grid, volume.LeftOut);
  if (fields.Dimensions[0] >= 4 && fields.Dimensions[4] > 1)
  {
    if (fields.Dimensions[4] > MaximumTimeSteps)
    {
      return header.MakeError(StatusCode::Unsupported, "it has too many time steps");
    }
    TakeTimes(fields, volume);
  }
  if (choice.Step >= std::max<std::size_t>(1, volume.Times.size()))
  {
    return volume; // of which OpenedVolume knows what to say
  }
  auto source = raw.Open(files);
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  const bool hasSlope = fields.Scale.Slope != 0 && std::isfinite(fields.Scale.Slope);
  if (hasSlope && !std::isfinite(fields.Scale.Intercept))
  {
    return header.MakeError(
      StatusCode::Corrupt, "its samples have a slope, and an intercept that is not finite");
  }
  const bool isScaled = hasSlope && !fields.Scale.IsIdentity();
  const ValueType type = isScaled ? FindScaledType(raw.Type) : raw.Type;
  if (isScaled)
  {
    *source = std::make_unique<ConvertedSource>(std::move(*source), raw.Type, fields.Scale, type);
  }
  volume.Grid = raw.Grid;
  volume.Arrays = { { "NIFTI", type, 1 } };
  volume.Source = std::move(*source);
  volume.Files = raw.Paths;
  if (fields.IsPair)
  {
    volume.Files.push_back(path);
  }
  return volume;
}

} // namespace isosurface
