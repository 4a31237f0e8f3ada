// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexHeader.h"

#include "Base/Checksum.h"
#include "Base/Coding.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

//   0  8  "EIXcode\n"
//   8  4  format version
//  12  4  size of the header, its checksum included
//  16  1  value type      17  1  mode      18  1  profile      19  1  quantization bits
//  20  4  number of isovalues
//  24  8  maximum error   32  8  quantization minimum          40  8  quantization maximum
//  48  48 extent: 6 int64
//  96  24 origin         120  24 spacing  144  72 direction: float64
// 216  8  number of blocks that the writer means to look at
// 224  8  time            232  1  whether there is a time
// 233  1  preview level   234  2  zeros    236  4  number of attributes
// 240  8  preview maximum error
// 248  8n isovalues: float64
//         attributes: value type (1), components (1), 1 if normals (1), zero (1), error (8), name
//         array, source
//      8  checksum of all before
// A name, the array and the source: size (4), then so many bytes of UTF-8.
constexpr char Magic[8] = { 'E', 'I', 'X', 'c', 'o', 'd', 'e', '\n' };
// Versions 2 and 3 are those with the compact profile; all else is written as version 1.
constexpr std::uint32_t LeastVersion = 1;
constexpr std::uint32_t GreatestVersion = 3;
constexpr std::size_t ChecksumSize = 8;
constexpr std::size_t MostIsovalues = 65536;
constexpr std::size_t MostAttributes = 256;
constexpr std::size_t MostTextSize = 65535;
constexpr int MostPreviewLevel = 6;
constexpr int MostTupleSize = 64;
constexpr int MostComponents = 256; // of all attributes together
// So that global ids (3 * vertex + axis, for every isovalue) fit 63 bits.
constexpr double MostGlobalIds = 9.0e18;

template <typename T>
void AppendValue(std::vector<std::uint8_t>& bytes, T value)
{
  std::uint8_t stored[sizeof(T)];
  StoreLittleEndian(stored, value);
  bytes.insert(bytes.end(), stored, stored + sizeof(T));
}

void AppendText(std::vector<std::uint8_t>& bytes, const std::string& text)
{
  AppendValue(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

Status MakeInvalid(const char* reason)
{
  return { StatusCode::InvalidArgument, reason };
}

Status CheckGrid(const EdgeIndexHeader& header)
{
  double vertices = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    constexpr std::int64_t most = std::int64_t(1) << 40;
    const std::int64_t low = header.Geometry.Extent[2 * axis];
    const std::int64_t high = header.Geometry.Extent[2 * axis + 1];
    if (low < -most || high > most || high < low)
    {
      return MakeInvalid("The grid has no vertices or too many.");
    }
    vertices *= static_cast<double>(high - low + 1);
  }
  if (3 * vertices * static_cast<double>(std::max<std::size_t>(1, header.Isovalues.size())) >
    MostGlobalIds)
  {
    return MakeInvalid("The grid has too many vertices for 64-bit ids of its edges.");
  }
  return Status::Ok();
}

Status CheckAttributes(const EdgeIndexHeader& header)
{
  if (header.Attributes.size() > MostAttributes)
  {
    return MakeInvalid("There are too many attributes.");
  }
  int components = 0;
  int normals = 0;
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    components += attribute.NumberOfComponents;
    normals += attribute.IsNormals ? 1 : 0;
    if (attribute.Type != ValueType::Float32 && attribute.Type != ValueType::Float64)
    {
      return MakeInvalid("An attribute is of float32 or float64, as points have it.");
    }
    if (attribute.NumberOfComponents < 1 || attribute.NumberOfComponents > MostTupleSize)
    {
      return MakeInvalid("An attribute must have 1 to 64 components.");
    }
    if (attribute.Name.size() > MostTextSize)
    {
      return MakeInvalid("The name of an attribute is too long.");
    }
    if (!(attribute.MaximumError >= 0) || !std::isfinite(attribute.MaximumError))
    {
      return MakeInvalid("The error of an attribute is bounded by a number that is not negative.");
    }
    if (attribute.IsNormals &&
      (attribute.Type != ValueType::Float32 || attribute.NumberOfComponents != 3))
    {
      return MakeInvalid("Normals are three float32.");
    }
  }
  if (components > MostComponents || normals > 1)
  {
    return MakeInvalid("There are more than 256 components of attributes, or normals twice.");
  }
  return Status::Ok();
}

Status CheckPreview(const EdgeIndexHeader& header)
{
  if (header.PreviewLevel < 0 || header.PreviewLevel > MostPreviewLevel)
  {
    return MakeInvalid("The level of the preview must be 0 to 6.");
  }
  if (header.PreviewLevel > 0 &&
    (!(header.PreviewMaximumError > 0 && header.PreviewMaximumError <= 0.5) ||
      header.MakePreview().GetIntervals().GetCount() == 0))
  {
    return MakeInvalid("The maximum error of the preview must lie above 0 and not above 0.5 of its "
                       "voxels, and be coarser than float coordinates are.");
  }
  return Status::Ok();
}

Status CheckSettings(const EdgeIndexHeader& header)
{
  const EdgeIndexSettings& settings = header.Settings;
  if (settings.Mode == EdgeIndexMode::Bounded || settings.Mode == EdgeIndexMode::Smallest)
  {
    if (!(settings.MaximumError > 0 && settings.MaximumError <= 0.5))
    {
      return MakeInvalid("The maximum error must lie above 0 and not above 0.5 voxels.");
    }
    if (header.GetIntervals().GetCount() == 0)
    {
      return MakeInvalid("The maximum error is finer than float coordinates on this grid are; "
                         "lossless mode keeps them exactly.");
    }
  }
  if (settings.Mode == EdgeIndexMode::Quantized)
  {
    if (settings.QuantizationBits < 2 || settings.QuantizationBits > 24)
    {
      return MakeInvalid("Values can be quantized to 2 to 24 bits.");
    }
    if (!std::isfinite(settings.QuantizationMinimum) ||
      !std::isfinite(settings.QuantizationMaximum) ||
      !std::isfinite(settings.QuantizationMaximum - settings.QuantizationMinimum) ||
      !(settings.QuantizationMinimum < settings.QuantizationMaximum))
    {
      return MakeInvalid("The range to quantize is empty or not finite.");
    }
  }
  return Status::Ok();
}

} // namespace

Status EdgeIndexHeader::Check() const
{
  if (this->Isovalues.size() > MostIsovalues)
  {
    return MakeInvalid("There are too many isovalues.");
  }
  if (this->Array.size() > MostTextSize || this->Source.size() > MostTextSize)
  {
    return MakeInvalid("The name of the array or of the source is too long.");
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckGrid(*this));
  ISOSURFACE_RETURN_IF_ERROR(CheckAttributes(*this));
  ISOSURFACE_RETURN_IF_ERROR(CheckPreview(*this));
  return CheckSettings(*this);
}

CrossingIntervals EdgeIndexHeader::GetIntervals() const
{
  // A structured coordinate is rounded to float at the end; and at worst its parameter was before.
  double largest = 1;
  for (const std::int64_t bound : this->Geometry.Extent)
  {
    largest = std::max(largest, std::abs(static_cast<double>(bound)) + 1);
  }
  int exponent = 0;
  std::frexp(largest, &exponent);
  const double rounding = std::ldexp(1.0, exponent - 25) + std::ldexp(1.0, -20);
  const double spare = this->Settings.MaximumError - rounding;
  // Not more bins than float parameters tell apart well.
  if (!(spare > 0) || 0.5 / spare > 1048576.0)
  {
    return {};
  }
  if (IsCurved(this->GetScheme()))
  {
    constexpr double unit = 2.0 * (1 << CrossingIntervals::UnitBits);
    return CrossingIntervals::MakeOfWidth(static_cast<std::uint32_t>(spare * unit));
  }
  return CrossingIntervals::MakeEqual(static_cast<std::uint32_t>(std::ceil(0.5 / spare)));
}

EdgeIndexHeader EdgeIndexHeader::MakePreview() const
{
  EdgeIndexHeader header = *this;
  header.Geometry = this->Geometry.Coarsen(this->PreviewLevel);
  header.Settings.Mode = EdgeIndexMode::Bounded;
  header.Settings.Profile = EdgeIndexProfile::Fast;
  header.Settings.MaximumError = this->PreviewMaximumError;
  header.PreviewLevel = 0;
  header.Attributes.clear();
  return header;
}

ValueType EdgeIndexHeader::GetDecodedType() const
{
  return this->Settings.Mode == EdgeIndexMode::Quantized ? ValueType::Float32 : this->Type;
}

BlockScheme EdgeIndexHeader::GetScheme() const
{
  switch (this->Settings.Profile)
  {
    case EdgeIndexProfile::Fast:
      return BlockScheme::Fast;
    case EdgeIndexProfile::Compact:
      return this->CompactVersion == 2 ? BlockScheme::Fitted : BlockScheme::Compact;
    default:
      return BlockScheme::Mixed;
  }
}

void EdgeIndexHeader::Append(std::vector<std::uint8_t>& bytes) const
{
  const std::size_t first = bytes.size();
  bytes.insert(bytes.end(), Magic, Magic + sizeof(Magic));
  AppendValue(bytes,
    this->Settings.Profile == EdgeIndexProfile::Compact ? this->CompactVersion : LeastVersion);
  AppendValue(bytes, std::uint32_t{ 0 }); // the size, at the end
  bytes.push_back(static_cast<std::uint8_t>(this->Type));
  bytes.push_back(static_cast<std::uint8_t>(this->Settings.Mode));
  bytes.push_back(static_cast<std::uint8_t>(this->Settings.Profile));
  bytes.push_back(static_cast<std::uint8_t>(this->Settings.QuantizationBits));
  AppendValue(bytes, static_cast<std::uint32_t>(this->Isovalues.size()));
  AppendValue(bytes, this->Settings.MaximumError);
  AppendValue(bytes, this->Settings.QuantizationMinimum);
  AppendValue(bytes, this->Settings.QuantizationMaximum);
  const auto appendAll = [&bytes](const auto& values)
  {
    for (const auto value : values)
    {
      AppendValue(bytes, value);
    }
  };
  appendAll(this->Geometry.Extent);
  appendAll(this->Geometry.Origin);
  appendAll(this->Geometry.Spacing);
  appendAll(this->Geometry.Direction);
  AppendValue(bytes, this->NumberOfBlocks);
  AppendValue(bytes, this->Time.value_or(0));
  bytes.push_back(this->Time.has_value() ? 1 : 0);
  bytes.push_back(static_cast<std::uint8_t>(this->PreviewLevel));
  AppendValue(bytes, std::uint16_t{ 0 });
  AppendValue(bytes, static_cast<std::uint32_t>(this->Attributes.size()));
  AppendValue(bytes, this->PreviewMaximumError);
  appendAll(this->Isovalues);
  for (const EdgeIndexAttribute& attribute : this->Attributes)
  {
    bytes.push_back(static_cast<std::uint8_t>(attribute.Type));
    bytes.push_back(static_cast<std::uint8_t>(attribute.NumberOfComponents));
    bytes.push_back(attribute.IsNormals ? 1 : 0);
    bytes.push_back(0);
    AppendValue(bytes, attribute.MaximumError);
    AppendText(bytes, attribute.Name);
  }
  AppendText(bytes, this->Array);
  AppendText(bytes, this->Source);
  StoreLittleEndian(
    bytes.data() + first + 12, static_cast<std::uint32_t>(bytes.size() - first + ChecksumSize));
  AppendValue(bytes, ComputeChecksum(bytes.data() + first, bytes.size() - first));
}

namespace
{

Status MakeCorrupt(const char* reason)
{
  return { StatusCode::Corrupt, std::string("The edge-index header ") + reason + "." };
}

// Reads the values of a header one after the other; behind the end they are 0.
class HeaderReader
{
public:
  HeaderReader(const std::uint8_t* bytes, std::size_t size)
    : Next(bytes)
    , End(bytes + size)
  {
  }
  template <typename T>
  T Read()
  {
    T value{};
    this->Failed = this->Failed || this->GetLeft() < sizeof(T);
    if (!this->Failed)
    {
      value = LoadLittleEndian<T>(this->Next);
      this->Next += sizeof(T);
    }
    return value;
  }
  template <typename Values>
  void ReadAll(Values& values)
  {
    for (auto& value : values)
    {
      value = this->Read<std::decay_t<decltype(value)>>();
    }
  }
  std::string ReadText()
  {
    const auto size = this->Read<std::uint32_t>();
    this->Failed = this->Failed || size > MostTextSize || this->GetLeft() < size;
    std::string text;
    if (!this->Failed)
    {
      text.assign(reinterpret_cast<const char*>(this->Next), size);
      this->Next += size;
    }
    return text;
  }
  std::size_t GetLeft() const { return static_cast<std::size_t>(this->End - this->Next); }
  bool HasFailed() const { return this->Failed; }

private:
  const std::uint8_t* Next;
  const std::uint8_t* End;
  bool Failed = false;
};

EdgeIndexAttribute ReadAttribute(HeaderReader& reader, bool& isKnown)
{
  EdgeIndexAttribute attribute;
  const auto type = reader.Read<std::uint8_t>();
  attribute.NumberOfComponents = reader.Read<std::uint8_t>();
  const auto normals = reader.Read<std::uint8_t>();
  const auto zero = reader.Read<std::uint8_t>();
  attribute.MaximumError = reader.Read<double>();
  attribute.Name = reader.ReadText();
  isKnown =
    isKnown && type <= static_cast<std::uint8_t>(ValueType::Float64) && normals <= 1 && zero == 0;
  attribute.Type = isKnown ? static_cast<ValueType>(type) : ValueType::Float32;
  attribute.IsNormals = normals == 1;
  return attribute;
}

} // namespace

bool EdgeIndexHeader::IsBegin(const std::uint8_t* bytes)
{
  return std::memcmp(bytes, Magic, sizeof(Magic)) == 0;
}

Result<std::size_t> EdgeIndexHeader::ParseSize(const std::uint8_t* bytes)
{
  if (!IsBegin(bytes))
  {
    return Status(
      StatusCode::Corrupt, "This is not an edge-index stream: it does not begin with EIXcode.");
  }
  const auto version = LoadLittleEndian<std::uint32_t>(bytes + 8);
  if (version < LeastVersion || version > GreatestVersion)
  {
    return Status(StatusCode::Unsupported, "The edge-index stream is of another version.");
  }
  const std::size_t size = LoadLittleEndian<std::uint32_t>(bytes + 12);
  if (size < LeastSize || size > GreatestSize)
  {
    return MakeCorrupt("has a size that cannot be");
  }
  return size;
}

Result<EdgeIndexHeader> EdgeIndexHeader::Parse(
  const std::uint8_t* bytes, std::size_t size, std::size_t& used)
{
  used = 0;
  if (size < LeastSize)
  {
    return MakeCorrupt("is cut off");
  }
  const Result<std::size_t> length = ParseSize(bytes);
  if (!length.IsOk())
  {
    return length.GetStatus();
  }
  if (size < *length)
  {
    return MakeCorrupt("is cut off");
  }
  if (LoadLittleEndian<std::uint64_t>(bytes + *length - ChecksumSize) !=
    ComputeChecksum(bytes, *length - ChecksumSize))
  {
    return MakeCorrupt("does not match its checksum");
  }
  EdgeIndexHeader header;
  HeaderReader reader(bytes + 16, *length - ChecksumSize - 16);
  const auto version = LoadLittleEndian<std::uint32_t>(bytes + 8);
  const auto type = reader.Read<std::uint8_t>();
  const auto mode = reader.Read<std::uint8_t>();
  const auto profile = reader.Read<std::uint8_t>();
  bool isKnown = type <= static_cast<std::uint8_t>(ValueType::Float64) &&
    mode <= static_cast<std::uint8_t>(EdgeIndexMode::Smallest) &&
    profile <= static_cast<std::uint8_t>(EdgeIndexProfile::Compact) &&
    (profile == static_cast<std::uint8_t>(EdgeIndexProfile::Compact)) == (version > LeastVersion);
  header.Settings.QuantizationBits = reader.Read<std::uint8_t>();
  const std::size_t isovalues = reader.Read<std::uint32_t>();
  header.Settings.MaximumError = reader.Read<double>();
  header.Settings.QuantizationMinimum = reader.Read<double>();
  header.Settings.QuantizationMaximum = reader.Read<double>();
  reader.ReadAll(header.Geometry.Extent);
  reader.ReadAll(header.Geometry.Origin);
  reader.ReadAll(header.Geometry.Spacing);
  reader.ReadAll(header.Geometry.Direction);
  header.NumberOfBlocks = reader.Read<std::uint64_t>();
  const auto time = reader.Read<double>();
  const auto hasTime = reader.Read<std::uint8_t>();
  header.PreviewLevel = reader.Read<std::uint8_t>();
  const auto zeros = reader.Read<std::uint16_t>();
  const std::size_t attributes = reader.Read<std::uint32_t>();
  header.PreviewMaximumError = reader.Read<double>();
  if (isovalues > MostIsovalues || attributes > MostAttributes ||
    isovalues > reader.GetLeft() / sizeof(double))
  {
    return MakeCorrupt("has a size that does not fit");
  }
  header.Isovalues.resize(isovalues);
  reader.ReadAll(header.Isovalues);
  for (std::size_t n = 0; n < attributes && !reader.HasFailed(); ++n)
  {
    header.Attributes.push_back(ReadAttribute(reader, isKnown));
  }
  header.Array = reader.ReadText();
  header.Source = reader.ReadText();
  if (reader.HasFailed() || reader.GetLeft() != 0)
  {
    return MakeCorrupt("has a size that does not fit");
  }
  if (!isKnown || hasTime > 1 || zeros != 0)
  {
    return MakeCorrupt("names a type, mode or profile that its version does not have");
  }
  header.Type = static_cast<ValueType>(type);
  header.Settings.Mode = static_cast<EdgeIndexMode>(mode);
  header.Settings.Profile = static_cast<EdgeIndexProfile>(profile);
  if (header.Settings.Profile == EdgeIndexProfile::Compact)
  {
    header.CompactVersion = version;
  }
  if (hasTime == 1)
  {
    header.Time = time;
  }
  const Status valid = header.Check();
  if (!valid.IsOk())
  {
    return Status(StatusCode::Corrupt, "The edge-index header is not valid: " + valid.GetMessage());
  }
  used = *length;
  return header;
}

} // namespace isosurface
