// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Netcdf/NetcdfFile.h"
#include "Formats/Source/ArraySource.h"
#include "Formats/Source/ConvertedSource.h"
#include "Formats/Source/FormatFunctions.h"
#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <numeric>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

bool IsOneOf(const std::string& text, std::initializer_list<const char*> names)
{
  return std::any_of(
    names.begin(), names.end(), [&text](const char* name) { return text == name; });
}

bool Contains(const std::string& text, const char* part)
{
  return text.find(part) != std::string::npos;
}

class NetcdfReader
{
public:
  NetcdfReader(const VolumeName& name, const NetcdfFile& file, const VolumeChoice& choice)
    : Name(name)
    , File(file)
    , Choice(choice)
  {
  }

  Result<OpenedVolume> Open()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->FindVariable());
    const std::string writer = this->File.ReadText(*this->Variable, "varid").value_or("");
    if (Contains(writer, "MINC") || this->File.FindVariable("rootvariable"))
    {
      return this->MakeError(StatusCode::Unsupported,
        "it is MINC, whose places and scale are not read: convert it to NIfTI, as mnc2nii does");
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto array, this->File.OpenArray(*this->Variable, this->Choice.CacheBytes));
    ISOSURFACE_RETURN_IF_ERROR(this->FindAxes());
    ISOSURFACE_RETURN_IF_ERROR(this->TakePlaces());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeTimes());
    ISOSURFACE_ASSIGN_OR_RETURN(auto parts,
      MakeVolumeArrays(this->Variable->Path.substr(this->Variable->Path.rfind('/') + 1),
        std::move(array), this->Axes, this->Choice.Step));
    ISOSURFACE_RETURN_IF_ERROR(
      TakeVolumeArrays(std::move(parts), this->Choice.Arrays, this->Volume));
    ISOSURFACE_RETURN_IF_ERROR(this->TakeLines());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeScale());
    for (ArrayDescription& taken : this->Volume.Arrays)
    {
      taken.Unit = this->File.ReadText(*this->Variable, "units").value_or("");
    }
    this->NoteLeftOut();
    return std::move(this->Volume);
  }

private:
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return this->File.MakeError(code, *this->Variable, reason);
  }

  Status FindVariable()
  {
    if (!this->Name.Within.empty())
    {
      this->Variable = this->File.FindVariable(this->Name.Within);
      return this->Variable
        ? Status::Ok()
        : Status(StatusCode::NotFound,
            this->Name.GetText() + ": cannot be read: there is no such variable");
    }
    std::string known;
    int count = 0;
    for (const NetcdfVariable& variable : this->File.GetVariables())
    {
      if (variable.Type && variable.Shape.size() >= 3 && variable.Shape.size() <= 5)
      {
        this->Variable = &variable;
        ++count;
        known += (known.empty() ? "" : ", ") + variable.Path + " (" + JoinNumbers(variable.Shape) +
          " " + variable.TypeName + ")";
      }
    }
    return count == 1
      ? Status::Ok()
      : Status(StatusCode::NotFound,
          this->Name.Path + ": cannot be read: " +
            (known.empty()
                ? "it has no variable of numbers with 3 to 5 axes"
                : "name one of its variables, as in " + this->Name.Path + ":variable: " + known));
  }

  /// x, y, z or t, if the coordinates of an axis tell; otherwise "?".
  char FindRole(std::size_t axis) const
  {
    const NetcdfVariable* coordinate = this->File.FindCoordinate(*this->Variable, axis);
    if (!coordinate)
    {
      return '?';
    }
    const auto text = [&](const char* attribute)
    { return LowerText(this->File.ReadText(*coordinate, attribute).value_or("")); };
    const std::string role = text("axis");
    if (IsOneOf(role, { "x", "y", "z", "t" }))
    {
      return role[0];
    }
    const std::string standard = text("standard_name");
    const std::string units = text("units");
    if (standard == "longitude" || standard == "projection_x_coordinate" ||
      IsOneOf(units, { "degrees_east", "degree_east", "degrees_e", "degree_e" }))
    {
      return 'x';
    }
    if (standard == "latitude" || standard == "projection_y_coordinate" ||
      IsOneOf(units, { "degrees_north", "degree_north", "degrees_n", "degree_n" }))
    {
      return 'y';
    }
    const bool hasDirection = !text("positive").empty();
    return standard == "time" || Contains(units, " since ") ? 't' : hasDirection ? 'z' : '?';
  }

  Status FindAxes()
  {
    std::string letters = this->Choice.Axes;
    const std::size_t rank = this->Variable->Shape.size();
    std::string dimensions;
    for (const std::string& name : this->Variable->Dimensions)
    {
      dimensions += (dimensions.empty() ? "" : ", ") + name;
    }
    if (letters.empty())
    {
      std::string roles;
      for (std::size_t axis = 0; axis < rank; ++axis)
      {
        roles += this->FindRole(axis);
      }
      for (std::size_t axis = 0; axis < rank; ++axis)
      {
        const char named = ArrayAxes::FindLetter(this->Variable->Dimensions[axis]);
        const bool isFree = named != '?' && roles.find(named) == std::string::npos;
        roles[axis] = roles[axis] == '?' && isFree ? named : roles[axis];
      }
      letters = Contains(roles, "?")
        ? ArrayAxes::Guess(this->Variable->Shape, roles, dimensions, this->Volume.LeftOut)
        : roles;
    }
    const auto axes = ArrayAxes::Parse(letters, rank);
    if (!axes.IsOk())
    {
      return this->MakeError(axes.GetStatus().GetCode(),
        axes.GetStatus().GetMessage() + " (its dimensions are " + dimensions +
          "; --axes says what they are)");
    }
    this->Axes = *axes;
    return Status::Ok();
  }

  /// Sets origin, spacing and direction from the coordinates of an axis of the grid, if these have
  /// equal steps, and keeps them.
  Status TakePlace(std::size_t gridAxis, int axis)
  {
    const NetcdfVariable* coordinate =
      this->File.FindCoordinate(*this->Variable, static_cast<std::size_t>(axis));
    if (!coordinate || this->Choice.IgnoresPlaces)
    {
      return Status::Ok();
    }
    ISOSURFACE_ASSIGN_OR_RETURN(auto numbers, this->File.ReadNumbers(*coordinate));
    const std::size_t count = numbers.size();
    const double first = count == 0 ? 0 : numbers.front();
    const double step = count < 2 ? 1 : (numbers.back() - first) / static_cast<double>(count - 1);
    // Coordinates may be floats of 32 bits.
    const double most = std::abs(step) * 1e-3 + std::abs(first) * 1e-6;
    for (std::size_t index = 0; index < count; ++index)
    {
      const double expected = first + step * static_cast<double>(index);
      if (!(std::abs(numbers[index] - expected) <= most) || step == 0)
      {
        this->Uneven = coordinate;
      }
    }
    this->Coordinates[gridAxis] = std::move(numbers);
    GridGeometry& grid = this->Volume.Grid;
    grid.Origin[gridAxis] = first;
    grid.Spacing[gridAxis] = std::abs(step);
    grid.Direction[4 * gridAxis] = step < 0 ? -1 : 1;
    return Status::Ok();
  }

  Status TakePlaces()
  {
    this->Volume.Grid.Extent = {};
    ISOSURFACE_RETURN_IF_ERROR(this->TakePlace(0, this->Axes.X));
    ISOSURFACE_RETURN_IF_ERROR(this->TakePlace(1, this->Axes.Y));
    return this->TakePlace(2, this->Axes.Z);
  }

  /// With uneven steps on some axis, the grid is a rectilinear one.
  Status TakeLines()
  {
    if (!this->Uneven)
    {
      return Status::Ok();
    }
    const Index3 dimensions = this->Volume.Grid.GetDimensions();
    GridLines lines;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      std::vector<double>& line = lines.Coordinates[axis];
      line = std::move(this->Coordinates[axis]);
      if (line.empty())
      {
        line.resize(static_cast<std::size_t>(dimensions[axis]));
        std::iota(line.begin(), line.end(), 0.0);
      }
    }
    const Status status = lines.Check(dimensions);
    if (!status.IsOk())
    {
      return this->File.MakeError(StatusCode::Unsupported, *this->Uneven,
        "the coordinates of " + this->Variable->Path + " have no equal steps, and " +
          status.GetMessage() + "; --spacing places the samples in spite of them");
    }
    this->Volume.Grid.Direction = GridGeometry().Direction;
    this->Volume.Lines = std::move(lines);
    return Status::Ok();
  }

  Status TakeTimes()
  {
    const NetcdfVariable* coordinate = this->Axes.Time < 0
      ? nullptr
      : this->File.FindCoordinate(*this->Variable, static_cast<std::size_t>(this->Axes.Time));
    if (!coordinate)
    {
      return Status::Ok();
    }
    ISOSURFACE_ASSIGN_OR_RETURN(this->Volume.Times, this->File.ReadNumbers(*coordinate));
    return Status::Ok();
  }

  /// Samples that were packed into integers.
  Status TakeScale()
  {
    ValueType type = ValueType::Float32;
    const auto slope = this->File.ReadNumber(*this->Variable, "scale_factor", &type);
    const auto intercept = this->File.ReadNumber(*this->Variable, "add_offset", &type);
    if (!slope && !intercept)
    {
      return Status::Ok();
    }
    if (this->Volume.Arrays.size() != 1 || this->Volume.Arrays[0].Components != 1)
    {
      return this->MakeError(StatusCode::Unsupported, "packed samples with channels");
    }
    const SampleScale scale = { slope.value_or(1), intercept.value_or(0) };
    if (!scale.IsIdentity())
    {
      type = type == ValueType::Float64 ? type : ValueType::Float32;
      ArrayDescription& array = this->Volume.Arrays[0];
      this->Volume.Source =
        std::make_unique<ConvertedSource>(std::move(this->Volume.Source), array.Type, scale, type);
      array.Type = type;
    }
    return Status::Ok();
  }

  void NoteLeftOut()
  {
    const auto note = [this](const std::string& text)
    { this->Volume.LeftOut += (this->Volume.LeftOut.empty() ? "" : "; ") + text; };
    for (const int axis : { this->Axes.X, this->Axes.Y, this->Axes.Z, this->Axes.Time })
    {
      const NetcdfVariable* coordinate = axis < 0
        ? nullptr
        : this->File.FindCoordinate(*this->Variable, static_cast<std::size_t>(axis));
      const auto units = coordinate ? this->File.ReadText(*coordinate, "units") : std::nullopt;
      if (units)
      {
        note("the unit of " + coordinate->Path + ", \"" + *units + "\", is not kept");
      }
      if (coordinate &&
        LowerText(this->File.ReadText(*coordinate, "positive").value_or("")) == "down")
      {
        note("the coordinates of " + coordinate->Path + " increase downwards, and are kept");
      }
    }
    for (const char* attribute : { "valid_range", "valid_min", "valid_max", "flag_meanings" })
    {
      if (this->File.HasAttribute(*this->Variable, attribute))
      {
        note(std::string("samples are kept whatever ") + attribute + " says");
      }
    }
    for (const char* attribute : { "_FillValue", "missing_value" })
    {
      if (const auto value = this->File.ReadNumber(*this->Variable, attribute))
      {
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%g", *value);
        note(std::string("missing samples stay the number of ") + attribute + ", " + text.data() +
          (this->File.ReadNumber(*this->Variable, "scale_factor") ? ", scaled" : ""));
        break;
      }
    }
  }

  const VolumeName& Name;
  const NetcdfFile& File;
  const VolumeChoice& Choice;
  const NetcdfVariable* Variable = nullptr;
  ArrayAxes Axes;
  std::array<std::vector<double>, 3> Coordinates; ///< of the grid's axes, as far as there are any
  const NetcdfVariable* Uneven = nullptr;         ///< one of them, without equal steps
  OpenedVolume Volume;
};

Result<OpenedVolume> OpenNetcdfVolume(
  FileSystem& /*files*/, const VolumeName& name, const VolumeChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, NetcdfFile::Open(name.Path));
  return NetcdfReader(name, file, choice).Open();
}

Result<std::vector<VolumeListing>> ListNetcdf(FileSystem& /*files*/, const VolumeName& name)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, NetcdfFile::Open(name.Path));
  std::vector<VolumeListing> list;
  for (const NetcdfVariable& variable : file.GetVariables())
  {
    list.push_back({ variable.Path, variable.Shape.empty() ? "1" : JoinNumbers(variable.Shape),
      variable.TypeName, variable.Storage });
  }
  return list;
}

} // namespace

/**
 * A variable of three or four axes in a NetCDF file: "file.nc:variable", "file.nc:group/variable", or
 * "file.nc" if there is only one. What the axes are is found by the CF conventions: the attributes axis,
 * standard_name and units of the coordinates; without them, the order is z, y, x, with t before. The
 * coordinates of z, y and x have equal steps, or ascend and make a rectilinear grid; those of equal
 * steps that descend reverse a direction. Times are the coordinates of t. Samples with scale_factor
 * and add_offset are scaled, to the type of these attributes.
 *
 * Source: "NetCDF Climate and Forecast (CF) Metadata Conventions" 1.10, sections 4, 5 and 8.1.
 */
extern "C" const FormatFunctions IsosurfaceNetcdfFormat;
const FormatFunctions IsosurfaceNetcdfFormat = { OpenNetcdfVolume, ListNetcdf };

} // namespace isosurface
