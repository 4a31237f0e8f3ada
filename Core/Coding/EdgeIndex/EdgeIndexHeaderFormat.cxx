// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexHeader.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <cstring>

namespace isosurface
{
namespace
{

//   0  8   "EIXcode\n"
//   8  4   format version
//  12  4   size of the header, including its checksum
//  16  1   value type
//  17  1   mode
//  18  1   profile
//  19  1   quantization bits
//  20  4   number n of isovalues
//  24  8   maximum error
//  32  8   quantization minimum
//  40  8   quantization maximum
//  48  48  extent: 6 int64
//  96  24  origin: 3 float64
// 120  24  spacing: 3 float64
// 144  72  direction: 9 float64
// 216  8   number of blocks that the writer visits
// 224  8   time
// 232  1   1 if there is a time
// 233  1   preview level
// 234  1   unit of length: its number; 0 if it is not known, and in version 1
// 235  1   1 if the surface is closed, 2 if it is around what is outside; + 4 if islands are left out; 0 before
//          version 3
// 236  4   number of attributes
// 240  8   maximum error of the preview
// 248  8n  isovalues: float64
//          for each attribute:
//            value type (1), components (1), 1 if normals (1), zero (1), maximum error (8), name
//          array: name
//          source: text
//      8   checksum of all before
// A name or text is its size in bytes (4), and UTF-8.
constexpr char Magic[8] = { 'E', 'I', 'X', 'c', 'o', 'd', 'e', '\n' };
// Only mode Smallest (EdgeIndexHeader::RoundsFaces) and a unit of length differ.
constexpr std::uint32_t Version = 2;
constexpr std::uint32_t NewestVersion = 3; // of closed surfaces, and without islands, alone
constexpr std::uint32_t PlainVersion = 1;
constexpr std::size_t SizeOffset = 12;
constexpr std::size_t FieldsOffset = 16;
constexpr std::size_t HeaderChecksumSize = 8;

void AppendText(std::vector<std::uint8_t>& bytes, const std::string& text)
{
  AppendLittleEndian(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

template <typename Values>
void AppendAll(std::vector<std::uint8_t>& bytes, const Values& values)
{
  for (const auto value : values)
  {
    AppendLittleEndian(bytes, value);
  }
}

void AppendAttribute(std::vector<std::uint8_t>& bytes, const EdgeIndexAttribute& attribute)
{
  bytes.push_back(static_cast<std::uint8_t>(attribute.Type));
  bytes.push_back(static_cast<std::uint8_t>(attribute.NumberOfComponents));
  bytes.push_back(attribute.IsNormals ? 1 : 0);
  bytes.push_back(0);
  AppendLittleEndian(bytes, attribute.MaximumError);
  AppendText(bytes, attribute.Name);
}

Status MakeCorruptHeader(const char* reason)
{
  return { StatusCode::Corrupt, std::string("The edge-index header ") + reason + "." };
}

// Reads the fields of a header. Numbers that the format does not have make it not valid.
class HeaderParser
{
public:
  HeaderParser(std::uint32_t version, const std::uint8_t* bytes, std::size_t size)
    : FormatVersion(version)
    , Reader(bytes, size)
  {
  }

  Status Parse(EdgeIndexHeader& header)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->ReadSettings(header));
    this->ReadGrid(header.Geometry);
    this->ReadProvenance(header);
    if (this->FormatVersion == PlainVersion && header.Geometry.Unit != LengthUnit::Unknown)
    {
      this->IsValid = false;
    }
    if (this->Isovalues > MaximumIsovalues || this->Attributes > MaximumAttributes ||
      this->Isovalues > this->Reader.GetRemaining() / sizeof(double))
    {
      return MakeCorruptHeader("has a size that does not fit");
    }
    header.Isovalues.resize(this->Isovalues);
    this->Reader.ReadAll(header.Isovalues);
    for (std::size_t n = 0; n < this->Attributes && !this->Reader.HasFailed(); ++n)
    {
      header.Attributes.push_back(this->ReadAttribute());
    }
    header.Array = this->ReadText();
    header.Source = this->ReadText();
    if (this->Reader.HasFailed() || this->Reader.GetRemaining() != 0)
    {
      return MakeCorruptHeader("has a size that does not fit");
    }
    return this->IsValid
      ? Status::Ok()
      : MakeCorruptHeader("has a type, mode, profile, unit or flag that the format does not have");
  }

private:
  Status ReadSettings(EdgeIndexHeader& header)
  {
    header.Type = this->ReadValueType();
    header.Settings.Mode = this->ReadEnumerator(EdgeIndexMode::Smallest);
    const auto profile = this->Reader.Read<std::uint8_t>();
    if (profile == 1 || profile == 2)
    {
      return { StatusCode::Unsupported,
        std::string("The edge-index stream has the profile ") +
          (profile == 1 ? "fast" : "compact") +
          ", which only ScalableIsosurface 1.0 reads and writes." };
    }
    this->IsValid = this->IsValid && (profile == 0 || profile == 3);
    header.Settings.Profile = static_cast<EdgeIndexProfile>(profile);
    header.Settings.QuantizationBits = this->Reader.Read<std::uint8_t>();
    this->Isovalues = this->Reader.Read<std::uint32_t>();
    header.Settings.MaximumError = this->Reader.Read<double>();
    header.Settings.QuantizationMinimum = this->Reader.Read<double>();
    header.Settings.QuantizationMaximum = this->Reader.Read<double>();
    return Status::Ok();
  }

  void ReadGrid(GridGeometry& geometry)
  {
    this->Reader.ReadAll(geometry.Extent);
    this->Reader.ReadAll(geometry.Origin);
    this->Reader.ReadAll(geometry.Spacing);
    this->Reader.ReadAll(geometry.Direction);
  }

  void ReadProvenance(EdgeIndexHeader& header)
  {
    header.NumberOfBlocks = this->Reader.Read<std::uint64_t>();
    const auto time = this->Reader.Read<double>();
    if (this->ReadFlag())
    {
      header.Time = time;
    }
    header.PreviewLevel = this->Reader.Read<std::uint8_t>();
    header.Geometry.Unit = this->ReadEnumerator(LengthUnit::Foot);
    const auto parts = this->Reader.Read<std::uint8_t>();
    const int closing = parts & 3;
    this->IsValid =
      this->IsValid && closing <= 2 && parts <= (this->FormatVersion < NewestVersion ? 0 : 6);
    header.LacksIslands = (parts & 4) != 0;
    if (closing > 0)
    {
      header.ClosedSides = GridSides::All();
      header.ClosedSides.AreBeyondInside = closing > 1;
    }
    this->Attributes = this->Reader.Read<std::uint32_t>();
    header.PreviewMaximumError = this->Reader.Read<double>();
  }

  EdgeIndexAttribute ReadAttribute()
  {
    EdgeIndexAttribute attribute;
    attribute.Type = this->ReadValueType();
    attribute.NumberOfComponents = this->Reader.Read<std::uint8_t>();
    attribute.IsNormals = this->ReadFlag();
    this->IsValid = this->Reader.Read<std::uint8_t>() == 0 && this->IsValid;
    attribute.MaximumError = this->Reader.Read<double>();
    attribute.Name = this->ReadText();
    return attribute;
  }

  ValueType ReadValueType()
  {
    const auto type = static_cast<ValueType>(this->Reader.Read<std::uint8_t>());
    const bool isKnown = GetValueTypeName(type) != nullptr;
    this->IsValid = this->IsValid && isKnown;
    return isKnown ? type : ValueType::Float64;
  }

  template <typename Enumeration>
  Enumeration ReadEnumerator(Enumeration last)
  {
    const auto number = this->Reader.Read<std::uint8_t>();
    const bool isKnown = number <= static_cast<std::uint8_t>(last);
    this->IsValid = this->IsValid && isKnown;
    return isKnown ? static_cast<Enumeration>(number) : last;
  }

  bool ReadFlag()
  {
    const auto flag = this->Reader.Read<std::uint8_t>();
    this->IsValid = this->IsValid && flag <= 1;
    return flag == 1;
  }

  std::string ReadText()
  {
    const auto size = this->Reader.Read<std::uint32_t>();
    this->IsValid = this->IsValid && size <= MaximumTextSize;
    const std::uint8_t* text = this->Reader.ReadBytes(size);
    return text ? std::string(reinterpret_cast<const char*>(text), size) : std::string();
  }

  std::uint32_t FormatVersion;
  ByteReader Reader;
  std::size_t Isovalues = 0;
  std::size_t Attributes = 0;
  bool IsValid = true;
};

} // namespace

void EdgeIndexHeader::Append(std::vector<std::uint8_t>& bytes) const
{
  const std::size_t first = bytes.size();
  bytes.insert(bytes.end(), Magic, Magic + sizeof(Magic));
  const bool isPlain = this->Geometry.Unit == LengthUnit::Unknown &&
    (this->Settings.Mode != EdgeIndexMode::Smallest || !this->RoundsFaces);
  const int closing = this->ClosedSides.IsEmpty() ? 0 : this->ClosedSides.AreBeyondInside ? 2 : 1;
  const int parts = closing + (this->LacksIslands ? 4 : 0);
  AppendLittleEndian(bytes, parts > 0 ? NewestVersion : isPlain ? PlainVersion : Version);
  AppendLittleEndian(bytes, std::uint32_t{ 0 }); // the size, see below
  bytes.push_back(static_cast<std::uint8_t>(this->Type));
  bytes.push_back(static_cast<std::uint8_t>(this->Settings.Mode));
  bytes.push_back(static_cast<std::uint8_t>(this->Settings.Profile));
  bytes.push_back(static_cast<std::uint8_t>(this->Settings.QuantizationBits));
  AppendLittleEndian(bytes, static_cast<std::uint32_t>(this->Isovalues.size()));
  AppendLittleEndian(bytes, this->Settings.MaximumError);
  AppendLittleEndian(bytes, this->Settings.QuantizationMinimum);
  AppendLittleEndian(bytes, this->Settings.QuantizationMaximum);
  AppendAll(bytes, this->Geometry.Extent);
  AppendAll(bytes, this->Geometry.Origin);
  AppendAll(bytes, this->Geometry.Spacing);
  AppendAll(bytes, this->Geometry.Direction);
  AppendLittleEndian(bytes, this->NumberOfBlocks);
  AppendLittleEndian(bytes, this->Time.value_or(0));
  bytes.push_back(this->Time.has_value() ? 1 : 0);
  bytes.push_back(static_cast<std::uint8_t>(this->PreviewLevel));
  bytes.push_back(static_cast<std::uint8_t>(this->Geometry.Unit));
  bytes.push_back(static_cast<std::uint8_t>(parts));
  AppendLittleEndian(bytes, static_cast<std::uint32_t>(this->Attributes.size()));
  AppendLittleEndian(bytes, this->PreviewMaximumError);
  AppendAll(bytes, this->Isovalues);
  for (const EdgeIndexAttribute& attribute : this->Attributes)
  {
    AppendAttribute(bytes, attribute);
  }
  AppendText(bytes, this->Array);
  AppendText(bytes, this->Source);
  StoreLittleEndian(bytes.data() + first + SizeOffset,
    static_cast<std::uint32_t>(bytes.size() - first + HeaderChecksumSize));
  AppendLittleEndian(bytes, ComputeChecksum(bytes.data() + first, bytes.size() - first));
}

bool EdgeIndexHeader::HasMagic(const std::uint8_t* bytes)
{
  return std::memcmp(bytes, Magic, sizeof(Magic)) == 0;
}

Result<std::size_t> EdgeIndexHeader::ParseSize(const std::uint8_t* bytes)
{
  if (!HasMagic(bytes))
  {
    return Status(
      StatusCode::Corrupt, "This is not an edge-index stream: it does not begin with EIXcode.");
  }
  const auto version = LoadLittleEndian<std::uint32_t>(bytes + sizeof(Magic));
  if (version < PlainVersion || version > NewestVersion)
  {
    return Status(StatusCode::Unsupported,
      "The edge-index stream has format version " + std::to_string(version) +
        "; this reader knows " + std::to_string(PlainVersion) + " to " +
        std::to_string(NewestVersion) + ".");
  }
  const std::size_t size = LoadLittleEndian<std::uint32_t>(bytes + SizeOffset);
  if (size < MinimumSize || size > MaximumSize)
  {
    return MakeCorruptHeader("has an impossible size");
  }
  return size;
}

Result<EdgeIndexHeader> EdgeIndexHeader::Parse(
  const std::uint8_t* bytes, std::size_t size, std::size_t& used)
{
  used = 0;
  if (size < MinimumSize)
  {
    return MakeCorruptHeader("is cut off");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const std::size_t length, ParseSize(bytes));
  if (size < length)
  {
    return MakeCorruptHeader("is cut off");
  }
  if (LoadLittleEndian<std::uint64_t>(bytes + length - HeaderChecksumSize) !=
    ComputeChecksum(bytes, length - HeaderChecksumSize))
  {
    return MakeCorruptHeader("does not match its checksum");
  }
  EdgeIndexHeader header;
  const auto version = LoadLittleEndian<std::uint32_t>(bytes + sizeof(Magic));
  header.RoundsFaces = version > PlainVersion;
  HeaderParser parser(version, bytes + FieldsOffset, length - HeaderChecksumSize - FieldsOffset);
  ISOSURFACE_RETURN_IF_ERROR(parser.Parse(header));
  const Status valid = header.Check();
  if (!valid.IsOk())
  {
    return Status(StatusCode::Corrupt, "The edge-index header is not valid: " + valid.GetMessage());
  }
  used = length;
  return header;
}

} // namespace isosurface
