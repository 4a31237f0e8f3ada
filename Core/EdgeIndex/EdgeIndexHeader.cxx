// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexHeader.h"

#include "Base/ByteOrder.h"
#include "Base/Checksum.h"

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
// 216  8n isovalues: float64
//      8  checksum of all before
constexpr char Magic[8] = { 'E', 'I', 'X', 'c', 'o', 'd', 'e', '\n' };
constexpr std::uint32_t Version = 1;
constexpr std::size_t FixedSize = 216;
constexpr std::size_t ChecksumSize = 8;
constexpr std::size_t MostIsovalues = 65536;
// So that global ids (3 * vertex + axis, for every isovalue) fit 63 bits.
constexpr double MostGlobalIds = 9.0e18;

template <typename T>
void AppendValue(std::vector<std::uint8_t>& bytes, T value)
{
  std::uint8_t stored[sizeof(T)];
  StoreLittleEndian(stored, value);
  bytes.insert(bytes.end(), stored, stored + sizeof(T));
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

Status CheckSettings(const EdgeIndexHeader& header)
{
  const EdgeIndexSettings& settings = header.Settings;
  if (settings.Mode == EdgeIndexMode::Bounded || settings.Mode == EdgeIndexMode::Smallest)
  {
    if (!(settings.MaximumError > 0 && settings.MaximumError <= 0.5))
    {
      return MakeInvalid("The maximum error must lie above 0 and not above 0.5 voxels.");
    }
    if (header.GetNumberOfBins() == 0)
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
  ISOSURFACE_RETURN_IF_ERROR(CheckGrid(*this));
  return CheckSettings(*this);
}

std::uint32_t EdgeIndexHeader::GetNumberOfBins() const
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
    return 0;
  }
  return static_cast<std::uint32_t>(std::ceil(0.5 / spare));
}

ValueType EdgeIndexHeader::GetDecodedType() const
{
  return this->Settings.Mode == EdgeIndexMode::Quantized ? ValueType::Float32 : this->Type;
}

void EdgeIndexHeader::Append(std::vector<std::uint8_t>& bytes) const
{
  const std::size_t first = bytes.size();
  bytes.insert(bytes.end(), Magic, Magic + sizeof(Magic));
  AppendValue(bytes, Version);
  AppendValue(
    bytes, static_cast<std::uint32_t>(FixedSize + 8 * this->Isovalues.size() + ChecksumSize));
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
  appendAll(this->Isovalues);
  AppendValue(bytes, ComputeChecksum(bytes.data() + first, bytes.size() - first));
}

Result<EdgeIndexHeader> EdgeIndexHeader::Parse(
  const std::uint8_t* bytes, std::size_t size, std::size_t& used)
{
  const auto corrupt = [](const char* reason) -> Status {
    return { StatusCode::Corrupt, std::string("The edge-index header ") + reason + "." };
  };
  used = 0;
  if (size < FixedSize + ChecksumSize)
  {
    return corrupt("is cut off");
  }
  if (std::memcmp(bytes, Magic, sizeof(Magic)) != 0)
  {
    return corrupt("does not begin as one");
  }
  if (LoadLittleEndian<std::uint32_t>(bytes + 8) != Version)
  {
    return Status(StatusCode::Unsupported, "The edge-index stream is of another version.");
  }
  const std::size_t length = LoadLittleEndian<std::uint32_t>(bytes + 12);
  const std::size_t isovalues = LoadLittleEndian<std::uint32_t>(bytes + 20);
  if (isovalues > MostIsovalues || length != FixedSize + 8 * isovalues + ChecksumSize)
  {
    return corrupt("has a size that does not fit");
  }
  if (size < length)
  {
    return corrupt("is cut off");
  }
  if (LoadLittleEndian<std::uint64_t>(bytes + length - ChecksumSize) !=
    ComputeChecksum(bytes, length - ChecksumSize))
  {
    return corrupt("does not match its checksum");
  }
  if (bytes[16] > static_cast<std::uint8_t>(ValueType::Float64) ||
    bytes[17] > static_cast<std::uint8_t>(EdgeIndexMode::Smallest) ||
    bytes[18] > static_cast<std::uint8_t>(EdgeIndexProfile::Fast))
  {
    return corrupt("names an unknown type, mode or profile");
  }
  EdgeIndexHeader header;
  header.Type = static_cast<ValueType>(bytes[16]);
  header.Settings.Mode = static_cast<EdgeIndexMode>(bytes[17]);
  header.Settings.Profile = static_cast<EdgeIndexProfile>(bytes[18]);
  header.Settings.QuantizationBits = bytes[19];
  header.Settings.MaximumError = LoadLittleEndian<double>(bytes + 24);
  header.Settings.QuantizationMinimum = LoadLittleEndian<double>(bytes + 32);
  header.Settings.QuantizationMaximum = LoadLittleEndian<double>(bytes + 40);
  const std::uint8_t* next = bytes + 48;
  const auto loadAll = [&next](auto& values)
  {
    for (auto& value : values)
    {
      value = LoadLittleEndian<std::decay_t<decltype(value)>>(next);
      next += sizeof(value);
    }
  };
  loadAll(header.Geometry.Extent);
  loadAll(header.Geometry.Origin);
  loadAll(header.Geometry.Spacing);
  loadAll(header.Geometry.Direction);
  header.Isovalues.resize(isovalues);
  loadAll(header.Isovalues);
  const Status valid = header.Check();
  if (!valid.IsOk())
  {
    return Status(StatusCode::Corrupt, "The edge-index header is not valid: " + valid.GetMessage());
  }
  used = length;
  return header;
}

} // namespace isosurface
