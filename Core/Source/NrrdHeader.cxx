// SPDX-License-Identifier: BSD-3-Clause
#include "Source/NrrdHeader.h"

#include "Source/HeaderText.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

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
  explicit NrrdParser(HeaderText& header)
    : Header(header)
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
  std::string Get(const char* name, const char* otherName, const std::string& otherwise) const
  {
    const auto found = this->Fields.find(name);
    const auto other = this->Fields.find(otherName);
    return found != this->Fields.end() ? found->second
      : other != this->Fields.end()    ? other->second
                                       : otherwise;
  }

  /// "field: value" up to an empty line, or to the end; "data file: LIST" is followed by names.
  Status TakeFields()
  {
    const auto magic = this->Header.TakeLine();
    if (!magic || magic->compare(0, 4, "NRRD") != 0)
    {
      return this->Corrupt("it does not begin with NRRD");
    }
    for (auto line = this->Header.TakeLine(); line && !HeaderText::Trim(*line).empty();
         line = this->Header.TakeLine())
    {
      const std::size_t colon = line->find(':');
      if ((*line)[0] == '#' || line->find(":=") == colon)
      {
        continue; // a comment, or a key of the user's
      }
      if (colon == std::string::npos)
      {
        return this->Corrupt("a line without \":\"");
      }
      const std::string name = HeaderText::Lower(HeaderText::Trim(line->substr(0, colon)));
      const std::string value = HeaderText::Trim(line->substr(colon + 1));
      this->Fields[name] = value;
      const bool isData = name == "data file" || name == "datafile";
      if (isData && HeaderText::Lower(value).compare(0, 4, "list") == 0)
      {
        break;
      }
    }
    return Status::Ok();
  }

  Status TakeSizes()
  {
    const auto dimension = HeaderText::ParseInteger(this->Get("dimension", "", ""));
    if (!dimension || *dimension < 2 || *dimension > 3)
    {
      return this->Unsupported("its dimension is neither 2 nor 3: one value a sample is read");
    }
    this->Axes = static_cast<std::size_t>(*dimension);
    const std::vector<std::string> sizes = HeaderText::Split(this->Get("sizes", "", ""));
    if (sizes.size() != this->Axes)
    {
      return this->Corrupt("\"sizes\" does not have as many numbers as dimensions");
    }
    this->Volume.Grid.Extent = { 0, 0, 0, 0, 0, 0 };
    for (std::size_t axis = 0; axis < this->Axes; ++axis)
    {
      const auto size = HeaderText::ParseInteger(sizes[axis]);
      if (!size || *size < 1 || *size > (std::int64_t{ 1 } << 31))
      {
        return this->Corrupt("\"sizes\" has an impossible number");
      }
      this->Volume.Grid.Extent[2 * axis + 1] = *size - 1;
    }
    for (const std::string& kind : HeaderText::Split(HeaderText::Lower(this->Get("kinds", "", ""))))
    {
      if (kind != "domain" && kind != "space" && kind != "time" && kind != "???" && kind != "none")
      {
        return this->Unsupported("an axis is of the kind \"" + kind + "\", not of space");
      }
    }
    return Status::Ok();
  }

  Status TakeSpace()
  {
    GridGeometry& grid = this->Volume.Grid;
    const std::vector<std::string> spacings = HeaderText::Split(this->Get("spacings", "", ""));
    for (std::size_t axis = 0; axis < spacings.size() && axis < this->Axes; ++axis)
    {
      const auto spacing = HeaderText::ParseDouble(spacings[axis]);
      // "nan" stands for an axis without a spacing.
      grid.Spacing[axis] = spacing && std::isfinite(*spacing) ? *spacing : 1;
    }
    const std::string origin = this->Get("space origin", "", "");
    const std::string directions = this->Get("space directions", "", "");
    if (!directions.empty())
    {
      const auto numbers =
        HeaderText::ParseDoubles(this->WithoutBrackets(directions), this->Axes * this->Axes);
      if (!numbers)
      {
        return this->Unsupported("its space directions are not a vector of space an axis");
      }
      for (std::size_t axis = 0; axis < this->Axes; ++axis)
      {
        double square = 0;
        for (std::size_t row = 0; row < this->Axes; ++row)
        {
          const double part = (*numbers)[axis * this->Axes + row];
          square += part * part;
        }
        grid.Spacing[axis] = std::sqrt(square);
        for (std::size_t row = 0; row < this->Axes && square > 0; ++row)
        {
          grid.Direction[3 * row + axis] = (*numbers)[axis * this->Axes + row] / grid.Spacing[axis];
        }
      }
    }
    if (!origin.empty())
    {
      const auto numbers = HeaderText::ParseDoubles(this->WithoutBrackets(origin), this->Axes);
      if (!numbers)
      {
        return this->Corrupt("\"space origin\" is not a vector of space");
      }
      std::copy(numbers->begin(), numbers->end(), grid.Origin.begin());
    }
    return Status::Ok();
  }

  static std::string WithoutBrackets(std::string text)
  {
    std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
    return text;
  }

  Status TakeSamples()
  {
    const std::string type = HeaderText::Lower(this->Get("type", "", ""));
    const auto found = GetTypeNames().find(type);
    if (found == GetTypeNames().end())
    {
      return this->Unsupported("the type \"" + type + "\" is not known");
    }
    this->Volume.Type = found->second;
    this->Volume.ArrayName = "ImageFile";
    const std::string encoding = HeaderText::Lower(this->Get("encoding", "", ""));
    this->Volume.IsGzip = encoding == "gzip" || encoding == "gz";
    if (!this->Volume.IsGzip && encoding != "raw")
    {
      return this->Unsupported("the encoding \"" + encoding + "\" is neither raw nor gzip");
    }
    const std::string endian = HeaderText::Lower(this->Get("endian", "", ""));
    if (endian != "little" && endian != "big" && GetValueSize(this->Volume.Type) > 1)
    {
      return this->Corrupt("\"endian\" is neither little nor big");
    }
    this->Volume.IsBigEndian = endian == "big";
    const auto skip = HeaderText::ParseInteger(this->Get("byte skip", "byteskip", "0"));
    const std::string lines = this->Get("line skip", "lineskip", "0");
    if (!skip || *skip < -1 || (*skip == -1 && this->Volume.IsGzip))
    {
      return this->Corrupt("\"byte skip\" is impossible");
    }
    if (lines != "0")
    {
      return this->Unsupported("lines before the samples (\"line skip\") are not passed over");
    }
    this->Volume.EndsWithSamples = *skip == -1;
    const auto bytes = static_cast<std::uint64_t>(*skip == -1 ? 0 : *skip);
    (this->Volume.IsGzip ? this->Volume.Skip : this->Volume.Offset) = bytes;
    return Status::Ok();
  }

  Status TakeFiles()
  {
    const std::string value = this->Get("data file", "datafile", "");
    const std::vector<std::string> words = HeaderText::Split(value);
    if (words.empty())
    {
      this->Volume.Paths = { this->Header.GetPath() };
      this->Volume.Offset += this->Header.GetPosition();
      return Status::Ok();
    }
    std::vector<std::string> names = { value };
    if (HeaderText::Lower(words[0]) == "list")
    {
      names.clear();
      for (auto line = this->Header.TakeLine(); line; line = this->Header.TakeLine())
      {
        if (!HeaderText::Trim(*line).empty())
        {
          names.push_back(HeaderText::Trim(*line));
        }
      }
    }
    else if (words.size() >= 4 && words[0].find('%') != std::string::npos)
    {
      const auto first = HeaderText::ParseInteger(words[1]);
      const auto last = HeaderText::ParseInteger(words[2]);
      const auto step = HeaderText::ParseInteger(words[3]);
      const auto expanded = first && last && step
        ? HeaderText::ExpandPattern(words[0], *first, *last, *step)
        : std::nullopt;
      if (!expanded)
      {
        return this->Corrupt("the pattern of \"data file\" makes no names");
      }
      names = *expanded;
    }
    for (const std::string& name : names)
    {
      this->Volume.Paths.push_back(this->Header.ResolvePath(name));
    }
    return names.empty() ? this->Corrupt("\"data file\" names no file") : Status::Ok();
  }

  HeaderText& Header;
  std::map<std::string, std::string> Fields;
  std::size_t Axes = 0;
  RawVolume Volume;
};

} // namespace

Result<RawVolume> ReadNrrdHeader(FileSystem& files, const std::string& path)
{
  auto header = HeaderText::Open(files, path);
  if (!header.IsOk())
  {
    return header.GetStatus();
  }
  return NrrdParser(*header).Parse();
}

} // namespace isosurface
