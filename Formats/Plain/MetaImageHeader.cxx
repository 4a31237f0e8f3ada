// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/RawVolume.h"

#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::pair<const char*, ValueType> TypeNames[] = { { "met_char", ValueType::Int8 },
  { "met_uchar", ValueType::UInt8 }, { "met_short", ValueType::Int16 },
  { "met_ushort", ValueType::UInt16 }, { "met_int", ValueType::Int32 },
  { "met_uint", ValueType::UInt32 }, { "met_long", ValueType::Int32 },
  { "met_ulong", ValueType::UInt32 }, { "met_long_long", ValueType::Int64 },
  { "met_ulong_long", ValueType::UInt64 }, { "met_float", ValueType::Float32 },
  { "met_double", ValueType::Float64 } };

class MetaImageParser
{
public:
  MetaImageParser(FileSystem& files, HeaderLines& header)
    : Files(files)
    , Header(header)
  {
  }

  Result<RawVolume> Parse()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->TakeFields());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeGrid());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeElement());
    ISOSURFACE_RETURN_IF_ERROR(this->TakeFiles());
    return std::move(this->Volume);
  }

private:
  Status Corrupt(const std::string& reason) const
  {
    return this->Header.MakeError(StatusCode::Corrupt, "not a MetaImage header: " + reason);
  }
  Status Unsupported(const std::string& reason) const
  {
    return this->Header.MakeError(StatusCode::Unsupported, "cannot be read: " + reason);
  }
  std::string Get(std::initializer_list<const char*> names, const std::string& otherwise) const
  {
    for (const char* name : names)
    {
      const auto found = this->Fields.find(name);
      if (found != this->Fields.end())
      {
        return found->second;
      }
    }
    return otherwise;
  }
  bool IsTrue(std::initializer_list<const char*> names) const
  {
    const std::string value = LowerText(this->Get(names, "false"));
    return value == "true" || value == "1" || value == "t";
  }

  /// Takes the fields. ElementDataFile is the last one; a list of files may follow it.
  Status TakeFields()
  {
    while (this->Fields.count("elementdatafile") == 0)
    {
      const auto line = this->Header.TakeLine();
      if (!line)
      {
        return this->Corrupt("there is no ElementDataFile");
      }
      const std::size_t equals = line->find('=');
      if (TrimText(*line).empty())
      {
        continue;
      }
      if (equals == std::string::npos)
      {
        return this->Corrupt("a line without \"=\"");
      }
      static const std::map<std::string, std::string> others = { { "position", "offset" },
        { "origin", "offset" }, { "rotation", "transformmatrix" },
        { "orientation", "transformmatrix" }, { "elementbyteordermsb", "binarydatabyteordermsb" } };
      const std::string name = LowerText(TrimText(line->substr(0, equals)));
      const std::string value = TrimText(line->substr(equals + 1));
      const auto other = others.find(name);
      const std::string key = other == others.end() ? name : other->second;
      if (!this->Fields.emplace(key, value).second && this->Fields[key] != value)
      {
        return this->Corrupt(key + " is there twice, with different values");
      }
    }
    return Status::Ok();
  }

  Status TakeGrid()
  {
    const auto dimensions = ParseInteger(this->Get({ "ndims" }, ""));
    if (!dimensions || *dimensions < 2 || *dimensions > 8)
    {
      return this->Unsupported("NDims is not 2 to 8");
    }
    const auto axes = static_cast<std::size_t>(*dimensions);
    const std::vector<std::string> sizes = SplitWords(this->Get({ "dimsize" }, ""));
    if (sizes.size() != axes)
    {
      return this->Corrupt("DimSize does not have NDims numbers");
    }
    GridGeometry& grid = this->Volume.Grid;
    grid.Extent = { 0, 0, 0, 0, 0, 0 };
    for (std::size_t axis = 0; axis < axes; ++axis)
    {
      const auto size = ParseInteger(sizes[axis]);
      if (!size || *size < 1 || *size > (std::int64_t{ 1 } << 31))
      {
        return this->Corrupt("DimSize has an impossible number");
      }
      if (axis < 3)
      {
        grid.Extent[2 * axis + 1] = *size - 1;
      }
      else if (*size > 1)
      {
        return this->Unsupported("NDims is more than 3");
      }
    }
    grid.Unit = FindLengthUnit(this->Get({ "distanceunits" }, ""));
    return this->TakeSpace(axes);
  }

  Status TakeSpace(std::size_t axes)
  {
    GridGeometry& grid = this->Volume.Grid;
    const auto take = [&](std::initializer_list<const char*> names, std::size_t count)
    { return ParseDoubles(this->Get(names, ""), count); };
    const auto has = [&](std::initializer_list<const char*> names)
    { return !this->Get(names, "").empty(); };
    const std::initializer_list<const char*> spacings = { "elementspacing", "elementsize" };
    const std::initializer_list<const char*> origins = { "offset" };
    const std::initializer_list<const char*> matrices = { "transformmatrix" };
    const auto spacing = has(spacings) ? take(spacings, axes) : std::vector<double>(axes, 1);
    const auto origin = has(origins) ? take(origins, axes) : std::vector<double>(axes, 0);
    std::optional<std::vector<double>> matrix(std::in_place, axes * axes, 0.0);
    for (std::size_t axis = 0; axis < axes; ++axis)
    {
      (*matrix)[axis * axes + axis] = 1;
    }
    matrix = has(matrices) ? take(matrices, axes * axes) : matrix;
    if (!spacing || !origin || !matrix)
    {
      return this->Corrupt("ElementSpacing, Offset or TransformMatrix has the wrong numbers");
    }
    for (std::size_t axis = 0; axis < std::min<std::size_t>(axes, 3); ++axis)
    {
      grid.Spacing[axis] = (*spacing)[axis];
      grid.Origin[axis] = (*origin)[axis];
      for (std::size_t row = 0; row < std::min<std::size_t>(axes, 3); ++row)
      {
        grid.Direction[3 * row + axis] = (*matrix)[axis * axes + row];
      }
    }
    return Status::Ok();
  }

  Status TakeElement()
  {
    const std::string type = LowerText(this->Get({ "elementtype" }, ""));
    const ValueType* found = nullptr;
    for (const auto& name : TypeNames)
    {
      found = type == name.first ? &name.second : found;
    }
    if (!found)
    {
      return this->Unsupported("the ElementType \"" + type + "\" is not known");
    }
    this->Volume.Type = *found;
    this->Volume.ArrayName = "MetaImage";
    if (this->Get({ "elementnumberofchannels" }, "1") != "1")
    {
      return this->Unsupported("it has more than one channel");
    }
    if (!this->IsTrue({ "binarydata" }) && this->Fields.count("binarydata") != 0)
    {
      return this->Unsupported("its samples are text");
    }
    this->Volume.IsBigEndian = this->IsTrue({ "binarydatabyteordermsb" });
    this->Volume.IsGzip = this->IsTrue({ "compresseddata" });
    const auto headerSize = ParseInteger(this->Get({ "headersize" }, "0"));
    if (!headerSize || *headerSize < -1)
    {
      return this->Corrupt("HeaderSize is impossible");
    }
    this->Volume.EndsWithSamples = *headerSize == -1;
    if (this->Volume.EndsWithSamples && this->Volume.IsGzip)
    {
      return this->Unsupported("its HeaderSize, -1, does not tell where compressed samples begin");
    }
    this->Volume.Offset = static_cast<std::uint64_t>(*headerSize == -1 ? 0 : *headerSize);
    this->TellScale();
    return Status::Ok();
  }

  /// Samples are those of the file, as ITK gives them.
  void TellScale()
  {
    const std::string slope = this->Get({ "elementtointensityfunctionslope" }, "1");
    const std::string offset = this->Get({ "elementtointensityfunctionoffset" }, "0");
    if (ParseDouble(slope) != 1.0 || ParseDouble(offset) != 0.0)
    {
      AddNote(this->Volume.LeftOut,
        "the samples are not scaled by ElementToIntensityFunctionSlope, " + slope +
          ", and -Offset, " + offset);
    }
  }

  Status TakeFiles()
  {
    const std::string value = this->Get({ "elementdatafile" }, "");
    const std::vector<std::string> words = SplitWords(value);
    const std::string first = words.empty() ? "" : words[0];
    if (LowerText(first) == "local")
    {
      this->Volume.Paths = { this->Header.GetPath() };
      // HeaderSize counts from the begin of the file.
      this->Volume.Offset =
        this->Volume.Offset > 0 ? this->Volume.Offset : this->Header.GetPosition();
    }
    else if (LowerText(first) == "list")
    {
      for (auto line = this->Header.TakeLine(); line; line = this->Header.TakeLine())
      {
        if (!TrimText(*line).empty())
        {
          this->Volume.Paths.push_back(this->Header.ResolvePath(TrimText(*line)));
        }
      }
    }
    else if (first.find('%') != std::string::npos &&
      !this->Files.Exists(this->Header.ResolvePath(value)))
    {
      return this->TakePattern(words);
    }
    else if (!value.empty())
    {
      this->Volume.Paths = { this->Header.ResolvePath(value) };
    }
    return this->Volume.Paths.empty() ? this->Corrupt("ElementDataFile names no file")
                                      : Status::Ok();
  }

  Status TakePattern(const std::vector<std::string>& words)
  {
    const std::int64_t slices = this->Volume.Grid.GetDimensions()[2];
    std::array<std::int64_t, 3> numbers = { 1, slices, 1 };
    for (std::size_t word = 1; word < words.size() && word < 4; ++word)
    {
      const auto number = ParseInteger(words[word]);
      if (!number)
      {
        return this->Corrupt("the pattern of ElementDataFile is not followed by numbers");
      }
      numbers[word - 1] = *number;
    }
    const auto names = ExpandPattern(words[0], numbers[0], numbers[1], numbers[2], slices);
    if (!names)
    {
      return this->Corrupt(
        "the pattern of ElementDataFile makes no names, or more than there are slices");
    }
    for (const std::string& name : *names)
    {
      this->Volume.Paths.push_back(this->Header.ResolvePath(name));
    }
    return Status::Ok();
  }

  FileSystem& Files;
  HeaderLines& Header;
  std::map<std::string, std::string> Fields;
  RawVolume Volume;
};

} // namespace

Result<RawVolume> ReadMetaImageHeader(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto header, HeaderLines::Open(files, path));
  return MetaImageParser(files, header).Parse();
}

} // namespace isosurface
