// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/RawVolume.h"

#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

const std::map<std::string, ValueType>& GetTypeNames()
{
  static const std::map<std::string, ValueType> names = { { "signed char", ValueType::Int8 },
    { "int8", ValueType::Int8 }, { "int8_t", ValueType::Int8 }, { "uchar", ValueType::UInt8 },
    { "unsigned char", ValueType::UInt8 }, { "uint8", ValueType::UInt8 },
    { "uint8_t", ValueType::UInt8 }, { "short", ValueType::Int16 },
    { "short int", ValueType::Int16 }, { "signed short", ValueType::Int16 },
    { "signed short int", ValueType::Int16 }, { "int16", ValueType::Int16 },
    { "int16_t", ValueType::Int16 }, { "ushort", ValueType::UInt16 },
    { "unsigned short", ValueType::UInt16 }, { "unsigned short int", ValueType::UInt16 },
    { "uint16", ValueType::UInt16 }, { "uint16_t", ValueType::UInt16 }, { "int", ValueType::Int32 },
    { "signed int", ValueType::Int32 }, { "int32", ValueType::Int32 },
    { "int32_t", ValueType::Int32 }, { "uint", ValueType::UInt32 },
    { "unsigned int", ValueType::UInt32 }, { "uint32", ValueType::UInt32 },
    { "uint32_t", ValueType::UInt32 }, { "longlong", ValueType::Int64 },
    { "long long", ValueType::Int64 }, { "long long int", ValueType::Int64 },
    { "signed long long", ValueType::Int64 }, { "signed long long int", ValueType::Int64 },
    { "int64", ValueType::Int64 }, { "int64_t", ValueType::Int64 },
    { "ulonglong", ValueType::UInt64 }, { "unsigned long long", ValueType::UInt64 },
    { "unsigned long long int", ValueType::UInt64 }, { "uint64", ValueType::UInt64 },
    { "uint64_t", ValueType::UInt64 }, { "float", ValueType::Float32 },
    { "double", ValueType::Float64 } };
  return names;
}

class NrrdParser
{
public:
  NrrdParser(FileSystem& files, HeaderLines& header)
    : Files(files)
    , Header(header)
  {
  }

  Result<RawVolume> Parse()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->TakeFields());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeSizes());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeSpace());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeSamples());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeFiles());
    return std::move(this->Volume);
  }

private:
  Status Corrupt(const std::string& reason) const
  {
    return this->Header.MakeError(StatusCode::Corrupt, "not a NRRD header: " + reason);
  }
  Status Unsupported(const std::string& reason) const
  {
    return this->Header.MakeError(StatusCode::Unsupported, "cannot be read: " + reason);
  }
  /// The value of a field; names are without spaces, which writers leave out, too.
  std::string Get(const char* name, const std::string& otherwise = {}) const
  {
    const auto found = this->Fields.find(name);
    return found != this->Fields.end() ? found->second : otherwise;
  }

  /// Words, and texts between quotation marks.
  static std::vector<std::string> SplitTexts(const std::string& text)
  {
    std::vector<std::string> texts;
    for (std::size_t at = text.find_first_not_of(" \t"); at != std::string::npos;
         at = text.find_first_not_of(" \t", at))
    {
      const bool isQuoted = text[at] == '"';
      const std::size_t end =
        std::min(isQuoted ? text.find('"', at + 1) : text.find_first_of(" \t", at), text.size());
      texts.push_back(text.substr(at + (isQuoted ? 1 : 0), end - at - (isQuoted ? 1 : 0)));
      at = std::min(text.size(), end + (isQuoted ? 1 : 0));
    }
    return texts;
  }

  /// Takes the lines "field: value" up to an empty line, or to the end. Names of files follow "data
  /// file: LIST".
  Status TakeFields()
  {
    const auto magic = this->Header.TakeLine();
    if (!magic || magic->compare(0, 4, "NRRD") != 0)
    {
      return this->Corrupt("it does not begin with NRRD");
    }
    for (auto line = this->Header.TakeLine(); line && !TrimText(*line).empty();
         line = this->Header.TakeLine())
    {
      const std::size_t colon = line->find(':');
      if ((*line)[0] == '#')
      {
        continue; // a comment
      }
      if (colon == std::string::npos)
      {
        return this->Corrupt("a line without \":\"");
      }
      if (line->compare(colon, 2, ":=") == 0)
      {
        continue; // a key/value pair
      }
      std::string name = LowerText(line->substr(0, colon));
      name.erase(
        std::remove_if(name.begin(), name.end(), [](char c) { return c == ' ' || c == '\t'; }),
        name.end());
      const std::string value = TrimText(line->substr(colon + 1));
      name = name == "centerings" ? "centers" : name;
      if (!this->Fields.emplace(name, value).second)
      {
        return this->Corrupt("two fields \"" + name + "\"");
      }
      static const std::set<std::string> known = { "dimension", "type", "blocksize", "encoding",
        "endian", "content", "oldmin", "oldmax", "datafile", "lineskip", "byteskip", "number",
        "sampleunits", "sizes", "spacings", "thicknesses", "axismins", "axismaxs", "centers",
        "labels", "units", "kinds", "space", "spacedimension", "spaceunits", "spaceorigin",
        "spacedirections", "measurementframe", "min", "max" };
      if (known.count(name) == 0)
      {
        AddNote(
          this->Volume.LeftOut, "its field \"" + name + "\" is none of NRRD's, and is not used");
      }
      if (name == "datafile" && LowerText(value).compare(0, 4, "list") == 0)
      {
        break;
      }
    }
    return Status::Ok();
  }

  /// An axis of the file. Axes of one sample may not belong to the grid.
  struct Axis
  {
    std::int64_t Size = 1;
    std::string Kind;
    std::string Spacing;
    std::string Minimum;
    std::string Maximum;
    std::string Center;
    std::string Unit;
    std::optional<std::vector<double>> Direction;

    /// Whether its samples are at different places in space (or time), instead of components of a
    /// value.
    bool IsOfSpace() const
    {
      return this->Kind.empty() || this->Kind == "domain" || this->Kind == "space" ||
        this->Kind == "time" || this->Kind == "???" || this->Kind == "none";
    }
  };

  Status TakeSizes()
  {
    const auto dimension = ParseInteger(this->Get("dimension"));
    if (!dimension || *dimension < 2 || *dimension > 16)
    {
      return this->Unsupported("its dimension is not 2 to 16");
    }
    const std::vector<std::string> sizes = SplitWords(this->Get("sizes"));
    if (sizes.size() != static_cast<std::size_t>(*dimension))
    {
      return this->Corrupt("\"sizes\" does not have as many numbers as dimensions");
    }
    this->Axes.resize(sizes.size());
    for (std::size_t axis = 0; axis < sizes.size(); ++axis)
    {
      const auto size = ParseInteger(sizes[axis]);
      if (!size || *size < 1 || *size > (std::int64_t{ 1 } << 31))
      {
        return this->Corrupt("\"sizes\" has an impossible number");
      }
      this->Axes[axis].Size = *size;
    }
    for (const auto& [name, member] : { std::pair("kinds", &Axis::Kind),
           { "spacings", &Axis::Spacing }, { "axismins", &Axis::Minimum },
           { "axismaxs", &Axis::Maximum }, { "centers", &Axis::Center }, { "units", &Axis::Unit } })
    {
      const std::string value = this->Get(name);
      const auto texts = SplitTexts(member == &Axis::Unit ? value : LowerText(value));
      for (std::size_t axis = 0; axis < sizes.size() && axis < texts.size(); ++axis)
      {
        this->Axes[axis].*member = texts[axis];
      }
    }
    return this->TakeDirections();
  }

  /// "space directions": "none" or "(a,b,c)" for each axis.
  Status TakeDirections()
  {
    const std::string text = this->Get("spacedirections");
    std::size_t at = text.find_first_not_of(" \t");
    for (std::size_t axis = 0; !text.empty() && axis < this->Axes.size(); ++axis)
    {
      const bool isVector = at != std::string::npos && text[at] == '(';
      const std::size_t end = isVector ? text.find(')', at) : text.find_first_of(" \t(", at);
      const std::string word = at == std::string::npos ? "" : text.substr(at, end - at);
      if (isVector ? end == std::string::npos : LowerText(word) != "none")
      {
        return this->Corrupt("\"space directions\" is not a vector or \"none\" an axis");
      }
      if (isVector)
      {
        this->Axes[axis].Direction = ParseVector(word);
        if (!this->Axes[axis].Direction)
        {
          return this->Corrupt("\"space directions\" has a vector that is none of space");
        }
      }
      at = end == std::string::npos ? end : text.find_first_not_of(" \t", isVector ? end + 1 : end);
    }
    return Status::Ok();
  }

  /// Drops axes of one sample until two or three axes are left.
  Status ChooseAxes()
  {
    const bool hasDirections = std::any_of(this->Axes.begin(), this->Axes.end(),
      [](const Axis& axis) { return axis.Direction.has_value(); });
    const auto isIdle = [hasDirections](const Axis& axis)
    { return axis.Size == 1 && (!axis.IsOfSpace() || (hasDirections && !axis.Direction)); };
    this->Axes.erase(
      std::remove_if(this->Axes.begin(), this->Axes.end(), isIdle), this->Axes.end());
    for (const Axis& axis : this->Axes)
    {
      if (!axis.IsOfSpace())
      {
        return this->Unsupported("an axis is of the kind \"" + axis.Kind +
          "\", not of space: only one value a sample is read");
      }
      if (hasDirections && !axis.Direction)
      {
        return this->Unsupported("an axis of several samples has no direction in space");
      }
    }
    // Drops the last ones first.
    for (std::size_t axis = this->Axes.size(); axis > 0 && this->Axes.size() > 3; --axis)
    {
      if (this->Axes[axis - 1].Size == 1)
      {
        this->Axes.erase(this->Axes.begin() + static_cast<std::ptrdiff_t>(axis - 1));
      }
    }
    if (this->Axes.size() < 2 || this->Axes.size() > 3)
    {
      return this->Unsupported("it has " + std::to_string(this->Axes.size()) +
        " axes of space: its dimension must be 2 or 3, with one value a sample");
    }
    return Status::Ok();
  }

  Status TakeSpace()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->ChooseAxes());
    for (std::size_t axis = 0; axis < this->Axes.size(); ++axis)
    {
      if (this->Axes[axis].Kind == "time")
      {
        AddNote(this->Volume.LeftOut, std::string("its time is the axis ") + "xyz"[axis]);
      }
    }
    GridGeometry& grid = this->Volume.Grid;
    grid.Extent = { 0, 0, 0, 0, 0, 0 };
    std::size_t space = this->Axes.size();
    for (std::size_t axis = 0; axis < this->Axes.size(); ++axis)
    {
      grid.Extent[2 * axis + 1] = this->Axes[axis].Size - 1;
      if (!this->Axes[axis].Direction)
      {
        this->TakeScalars(axis);
      }
      else
      {
        const std::vector<double>& vector = *this->Axes[axis].Direction;
        if (axis > 0 && vector.size() != space)
        {
          return this->Corrupt("\"space directions\" has vectors of different spaces");
        }
        space = vector.size();
        this->SetDirection(axis, vector);
      }
    }
    if (this->Axes.size() == 2 && space == 3)
    {
      this->SetNormal();
    }
    const std::string origin = this->Get("spaceorigin");
    if (!origin.empty())
    {
      const auto vector = ParseVector(origin);
      if (!vector || vector->size() != space)
      {
        return this->Corrupt("\"space origin\" is not a vector of space");
      }
      grid.Origin = {};
      std::copy(vector->begin(), vector->end(), grid.Origin.begin());
    }
    this->TakeUnits();
    return Status::Ok();
  }

  /// Spacing and origin of an axis without a direction. Minimum and maximum are at the first and the last
  /// sample (node), or at the borders of their cells (cell), which Teem takes where nothing is said.
  void TakeScalars(std::size_t axis)
  {
    // "nan" stands for what an axis does not have.
    const auto parse = [](const std::string& text)
    {
      const auto number = ParseDouble(text);
      return number && std::isfinite(*number) ? number : std::nullopt;
    };
    const Axis& from = this->Axes[axis];
    const auto minimum = parse(from.Minimum);
    const auto maximum = parse(from.Maximum);
    const std::int64_t parts = from.Size - (from.Center == "node" ? 1 : 0);
    auto spacing = parse(from.Spacing);
    if (!spacing && minimum && maximum && parts > 0)
    {
      spacing = (*maximum - *minimum) / static_cast<double>(parts);
    }
    GridGeometry& grid = this->Volume.Grid;
    grid.Spacing[axis] = spacing.value_or(1);
    if (minimum && spacing)
    {
      grid.Origin[axis] = *minimum + (from.Center == "node" ? 0 : *spacing / 2);
    }
    else if (minimum)
    {
      AddNote(this->Volume.LeftOut,
        "the minimum of an axis, " + from.Minimum + ", has no effect without spacing or maximum");
    }
  }

  /// The unit of length of the space, or else of the axes.
  void TakeUnits()
  {
    std::array<std::string, 3> units;
    const bool isOfSpace = this->Axes[0].Direction.has_value();
    const std::vector<std::string> texts = SplitTexts(this->Get("spaceunits"));
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      units[axis] = isOfSpace      ? (axis < texts.size() ? texts[axis] : "")
        : axis < this->Axes.size() ? this->Axes[axis].Unit
                                   : units[0];
    }
    if (isOfSpace && texts.size() == 2)
    {
      units[2] = units[0];
    }
    const bool isOne = units[1] == units[0] && units[2] == units[0];
    // The axes of the space are not those of the grid, whose lengths are no multiples of one unit then.
    if (isOfSpace && !isOne)
    {
      AddNote(
        this->Volume.LeftOut, "the units of its space are not kept: " + this->Get("spaceunits"));
      return;
    }
    TakeLengthUnits(units, this->Volume.Grid, this->Volume.LeftOut);
  }

  void SetDirection(std::size_t axis, const std::vector<double>& vector)
  {
    GridGeometry& grid = this->Volume.Grid;
    double square = 0;
    for (const double part : vector)
    {
      square += part * part;
    }
    grid.Spacing[axis] = std::sqrt(square);
    for (std::size_t row = 0; row < 3 && square > 0; ++row)
    {
      grid.Direction[3 * row + axis] = row < vector.size() ? vector[row] / grid.Spacing[axis] : 0;
    }
  }

  /// Sets the direction of z for a single slice in space.
  void SetNormal()
  {
    std::array<double, 9>& d = this->Volume.Grid.Direction;
    for (std::size_t row = 0; row < 3; ++row)
    {
      const std::size_t next = 3 * ((row + 1) % 3);
      const std::size_t last = 3 * ((row + 2) % 3);
      d[3 * row + 2] = d[next] * d[last + 1] - d[last] * d[next + 1];
    }
  }

  /// "(a,b,c)": one to three numbers.
  static std::optional<std::vector<double>> ParseVector(std::string text)
  {
    std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
    const std::size_t count = SplitWords(text).size();
    return count < 1 || count > 3 ? std::nullopt : ParseDoubles(text, count);
  }

  Status TakeSamples()
  {
    const std::string type = LowerText(this->Get("type"));
    const auto found = GetTypeNames().find(type);
    if (found == GetTypeNames().end())
    {
      return this->Unsupported("the type \"" + type + "\" is not known");
    }
    this->Volume.Type = found->second;
    this->Volume.ArrayName = "ImageFile";
    const std::vector<std::string> unit = SplitTexts(this->Get("sampleunits"));
    this->Volume.SampleUnit = unit.empty() ? "" : unit.front();
    for (const char* name : { "oldmin", "oldmax" })
    {
      if (const std::string value = LowerText(this->Get(name)); !value.empty() && value != "nan")
      {
        AddNote(this->Volume.LeftOut,
          std::string("samples are not brought back to the values before they were quantized (") +
            name + " " + value + ")");
      }
    }
    const std::string encoding = LowerText(this->Get("encoding"));
    this->Volume.IsGzip = encoding == "gzip" || encoding == "gz";
    if (!this->Volume.IsGzip && encoding != "raw")
    {
      return this->Unsupported("the encoding \"" + encoding + "\" is neither raw nor gzip");
    }
    const std::string endian = LowerText(this->Get("endian"));
    if (endian != "little" && endian != "big" && GetValueSize(this->Volume.Type) > 1)
    {
      return this->Corrupt("\"endian\" is neither little nor big");
    }
    this->Volume.IsBigEndian = endian == "big";
    const auto skip = ParseInteger(this->Get("byteskip", "0"));
    const auto lines = ParseInteger(this->Get("lineskip", "0"));
    if (!skip || *skip < -1 || (*skip == -1 && this->Volume.IsGzip))
    {
      return this->Corrupt("\"byte skip\" is impossible; -1 is of the encoding raw alone");
    }
    if (!lines || *lines < 0)
    {
      return this->Corrupt("\"line skip\" is impossible");
    }
    this->Volume.EndsWithSamples = *skip == -1;
    this->Volume.IsWhole = true;
    this->Volume.Lines = static_cast<std::uint64_t>(*lines);
    this->Volume.Skip = static_cast<std::uint64_t>(*skip == -1 ? 0 : *skip);
    return Status::Ok();
  }

  Status TakeFiles()
  {
    const std::string value = this->Get("datafile");
    const std::vector<std::string> words = SplitWords(value);
    if (words.empty())
    {
      this->Volume.Paths = { this->Header.GetPath() };
      this->Volume.Offset += this->Header.GetPosition();
      return Status::Ok();
    }
    std::vector<std::string> names = { value };
    if (LowerText(words[0]) == "list")
    {
      names.clear();
      for (auto line = this->Header.TakeLine(); line; line = this->Header.TakeLine())
      {
        if (!TrimText(*line).empty())
        {
          names.push_back(TrimText(*line));
        }
      }
    }
    else if (words.size() >= 4 && words[0].find('%') != std::string::npos &&
      !this->Files.Exists(this->Header.ResolvePath(value)))
    {
      const auto first = ParseInteger(words[1]);
      const auto last = ParseInteger(words[2]);
      const auto step = ParseInteger(words[3]);
      const std::int64_t slices = this->Volume.Grid.GetDimensions()[2];
      const auto expanded = first && last && step
        ? ExpandPattern(words[0], *first, *last, *step, slices)
        : std::nullopt;
      if (!expanded)
      {
        return this->Corrupt(
          "the pattern of \"data file\" makes no names, or more than there are slices");
      }
      names = *expanded;
    }
    for (const std::string& name : names)
    {
      this->Volume.Paths.push_back(this->Header.ResolvePath(name));
    }
    return names.empty() ? this->Corrupt("\"data file\" names no file") : Status::Ok();
  }

  FileSystem& Files;
  HeaderLines& Header;
  std::map<std::string, std::string> Fields; ///< names in lower case, without spaces
  std::vector<Axis> Axes;
  RawVolume Volume;
};

} // namespace

Result<RawVolume> ReadNrrdHeader(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto header, HeaderLines::Open(files, path));
  return NrrdParser(files, header).Parse();
}

} // namespace isosurface
