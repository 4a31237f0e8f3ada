// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrCodec.h"

#include "Formats/Source/FormatModule.h"
#include "Formats/Zarr/BloscCodec.h"

#include <lz4.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <climits>

namespace isosurface
{
namespace
{

std::uint32_t GetLittle(const std::uint8_t* bytes)
{
  return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8 |
    static_cast<std::uint32_t>(bytes[2]) << 16 | static_cast<std::uint32_t>(bytes[3]) << 24;
}

bool Inflate(const std::uint8_t* from, std::size_t fromSize, std::uint8_t* to, std::size_t size)
{
  z_stream stream = {};
  if (fromSize > UINT_MAX || size > UINT_MAX || ::inflateInit2(&stream, 15 + 32) != Z_OK)
  {
    return false;
  }
  stream.next_in = const_cast<Bytef*>(from); // zlib does not write to it
  stream.avail_in = static_cast<uInt>(fromSize);
  stream.next_out = to;
  stream.avail_out = static_cast<uInt>(size);
  const int code = ::inflate(&stream, Z_FINISH);
  const bool isWhole = code == Z_STREAM_END && stream.avail_out == 0;
  ::inflateEnd(&stream);
  return isWhole;
}

bool DecodeLz4(const std::uint8_t* from, std::size_t fromSize, std::uint8_t* to, std::size_t size)
{
  if (fromSize < 4 || fromSize > INT_MAX || size > INT_MAX || GetLittle(from) != size)
  {
    return false;
  }
  const int count = ::LZ4_decompress_safe(reinterpret_cast<const char*>(from + 4),
    reinterpret_cast<char*>(to), static_cast<int>(fromSize - 4), static_cast<int>(size));
  return count >= 0 && static_cast<std::size_t>(count) == size;
}

Result<const void*> LoadBlosc()
{
  return LoadFormatModule("BloscCodec", "its codec, blosc,");
}

bool DecodeBlosc(const std::uint8_t* from, std::size_t fromSize, std::uint8_t* to, std::size_t size)
{
  static const auto module = LoadBlosc();
  return module.IsOk() && (*static_cast<const BloscDecoder*>(*module))(from, fromSize, to, size);
}

bool Decompress(ZarrCodec codec, const std::uint8_t* from, std::size_t fromSize, std::uint8_t* to,
  std::size_t size)
{
  switch (codec)
  {
    case ZarrCodec::Inflate:
      return Inflate(from, fromSize, to, size);
    case ZarrCodec::Zstd:
      return ::ZSTD_decompress(to, size, from, fromSize) == size;
    case ZarrCodec::Lz4:
      return DecodeLz4(from, fromSize, to, size);
    case ZarrCodec::Blosc:
    default:
      return DecodeBlosc(from, fromSize, to, size);
  }
}

bool CheckCrc32c(const std::uint8_t* bytes, std::size_t size)
{
  return size >= 4 && ComputeCrc32c(bytes, size - 4) == GetLittle(bytes + size - 4);
}

} // namespace

std::optional<ZarrCodec> FindZarrCodec(const std::string& name)
{
  constexpr std::pair<const char*, ZarrCodec> known[] = { { "gzip", ZarrCodec::Inflate },
    { "zlib", ZarrCodec::Inflate }, { "zstd", ZarrCodec::Zstd }, { "lz4", ZarrCodec::Lz4 },
    { "blosc", ZarrCodec::Blosc }, { "crc32c", ZarrCodec::Crc32c } };
  for (const auto& [text, codec] : known)
  {
    if (name == text)
    {
      return codec;
    }
  }
  return std::nullopt;
}

Status LoadZarrCodec(ZarrCodec codec)
{
  return codec == ZarrCodec::Blosc ? LoadBlosc().GetStatus() : Status::Ok();
}

std::uint32_t ComputeCrc32c(const std::uint8_t* bytes, std::size_t size)
{
  static const auto table = []
  {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t byte = 0; byte < 256; ++byte)
    {
      std::uint32_t value = byte;
      for (int bit = 0; bit < 8; ++bit)
      {
        value = value >> 1 ^ ((value & 1) != 0 ? 0x82f63b78U : 0U);
      }
      made[byte] = value;
    }
    return made;
  }();
  std::uint32_t value = 0xffffffffU;
  for (std::size_t at = 0; at < size; ++at)
  {
    value = value >> 8 ^ table[(value ^ bytes[at]) & 0xff];
  }
  return ~value;
}

bool DecodeZarr(const std::vector<ZarrCodec>& codecs, const std::uint8_t* from,
  std::size_t fromSize, std::uint8_t* to, std::size_t size)
{
  // Checksums around the compressed bytes, then the compressor, then checksums within.
  std::size_t left = codecs.size();
  while (left > 0 && codecs[left - 1] == ZarrCodec::Crc32c)
  {
    if (!CheckCrc32c(from, fromSize))
    {
      return false;
    }
    fromSize -= 4;
    --left;
  }
  if (left == 0)
  {
    return fromSize == size && (std::copy_n(from, size, to), true);
  }
  const ZarrCodec compressor = codecs[left - 1];
  if (left == 1)
  {
    return Decompress(compressor, from, fromSize, to, size);
  }
  std::vector<std::uint8_t> inner(size + 4 * (left - 1));
  if (!Decompress(compressor, from, fromSize, inner.data(), inner.size()))
  {
    return false;
  }
  const std::vector<ZarrCodec> checksums(
    codecs.begin(), codecs.begin() + static_cast<std::ptrdiff_t>(left - 1));
  return DecodeZarr(checksums, inner.data(), inner.size(), to, size);
}

} // namespace isosurface
