// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrMetadata.h"

#include "Formats/Source/ConvertedSource.h"
#include "Formats/Zarr/JsonField.h"
#include "Ground/Volume/CutToRange.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

using Json = nlohmann::json;

constexpr std::int64_t MaximumSize = std::int64_t{ 1 } << 40;
constexpr double MaximumChunkBytes = 0x1p31;
constexpr double MaximumShardChunks = 0x1p22;
/// Of a list of codecs. There is one compressor at most; each checksum is a pass over the chunk.
constexpr std::size_t MaximumCodecs = 4;

class ZarrParser
{
public:
  ZarrParser(const ZarrNode& node, std::string folder)
    : Node(node)
    , Folder(std::move(folder))
  {
  }

  Result<ZarrMetadata> Parse()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Node.Version == 2 ? this->ParseSecond()
        : this->Node.Version == 3                      ? this->ParseThird()
                                                       : this->ParseN5());
    ISOSURFACE_RETURN_IF_ERROR(this->CheckSizes());
    const Numbers& shard = this->Metadata.Shard;
    this->Metadata.Storage =
      (this->Metadata.HasShards ? "shards of " + JoinNumbers(shard) + ", " : std::string()) +
      "chunks of " + JoinNumbers(this->Metadata.Chunk) + this->CodecNames;
    return std::move(this->Metadata);
  }

private:
  using Numbers = StoredArray::Numbers;

  Status Unsupported(const std::string& reason) const
  {
    return Status(StatusCode::Unsupported, this->Folder + ": cannot be read: " + reason);
  }
  Status Corrupt(const std::string& reason) const
  {
    return Status(StatusCode::Corrupt, this->Folder + ": cannot be read: its metadata " + reason);
  }

  Status TakeNumbers(const Json& list, const char* name, Numbers& numbers) const
  {
    numbers.clear();
    if (!list.is_array() || list.empty() || list.size() > 32)
    {
      return this->Corrupt(std::string("have no ") + name);
    }
    for (const Json& number : list)
    {
      const double value = number.is_number() ? number.get<double>() : -1;
      if (!(value >= 0 && value <= static_cast<double>(MaximumSize)))
      {
        return this->Corrupt(std::string("have an impossible ") + name);
      }
      numbers.push_back(static_cast<std::int64_t>(value));
    }
    return Status::Ok();
  }

  Status CheckSizes() const
  {
    const ZarrMetadata& data = this->Metadata;
    const std::size_t rank = data.Shape.size();
    if (data.Chunk.size() != rank || data.Shard.size() != rank ||
      data.Encoding.Order.size() != rank)
    {
      return this->Corrupt("have chunks of another number of axes than the array");
    }
    double bytes = static_cast<double>(GetValueSize(data.Type));
    double inShard = 1;
    for (std::size_t axis = 0; axis < rank; ++axis)
    {
      if (data.Chunk[axis] < 1 || data.Shard[axis] < 1 || data.Shard[axis] % data.Chunk[axis] != 0)
      {
        return this->Corrupt("have an impossible chunk");
      }
      bytes *= static_cast<double>(data.Chunk[axis]);
      const std::int64_t chunks = data.Shard[axis] / data.Chunk[axis];
      inShard *= static_cast<double>(chunks);
    }
    if (bytes > MaximumChunkBytes || inShard > MaximumShardChunks)
    {
      return this->Unsupported("its chunks have more than 2 GiB, or there are too many in a shard");
    }
    return Status::Ok();
  }

  /// "int16", "float16", ...
  Status TakeType(const std::string& name)
  {
    this->Metadata.IsHalf = name == "float16";
    const auto type = this->Metadata.IsHalf ? ValueType::Float32
      : name == "bool"                      ? ValueType::UInt8
                                            : FindValueType(name);
    if (!type)
    {
      return this->Unsupported("its data type, " + name + ", is none of real numbers");
    }
    this->Metadata.Type = *type;
    return Status::Ok();
  }

  Status TakeFill(const Json& fill)
  {
    if (fill.is_null())
    {
      return Status::Ok();
    }
    const std::string text = fill.is_string() ? fill.get<std::string>() : "";
    double number = std::numeric_limits<double>::quiet_NaN();
    const bool isHex = text.compare(0, 2, "0x") == 0;
    if (text == "Infinity" || text == "-Infinity")
    {
      number = text[0] == '-' ? -std::numeric_limits<double>::infinity()
                              : std::numeric_limits<double>::infinity();
    }
    else if (!fill.is_number() && !fill.is_boolean() && text != "NaN" && !isHex)
    {
      return this->Unsupported("its fill value is not a number");
    }
    else if (!fill.is_string())
    {
      number = fill.is_boolean() ? (fill.get<bool>() ? 1 : 0) : fill.get<double>();
    }
    return this->StoreFill(fill, isHex ? text : std::string(), number);
  }

  /// An integer of JSON that T has; nothing for others.
  template <typename T>
  static std::optional<T> FindWhole(const Json& number)
  {
    if (!std::is_integral_v<T> || !number.is_number_integer())
    {
      return std::nullopt;
    }
    // Less than 0, or up to the maximum of 64 bits.
    const bool isUnsigned = number.is_number_unsigned();
    const T value = isUnsigned ? static_cast<T>(number.get<std::uint64_t>())
                               : static_cast<T>(number.get<std::int64_t>());
    const bool isNegative = value < static_cast<T>(0);
    // JSON numbers of 64 bits are compared modulo 2^64.
    const Json back = value;
    return back == number && isNegative != isUnsigned ? std::optional<T>(value) : std::nullopt;
  }

  Status StoreFill(const Json& fill, const std::string& hex, double number)
  {
    const bool isFloat = IsFloatingType(this->Metadata.Type);
    if (!hex.empty())
    {
      return this->StoreBits(hex);
    }
    const bool isPossible = DispatchValueType(this->Metadata.Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        using Limits = std::numeric_limits<T>;
        T value = static_cast<T>(0);
        // Who writes the maximum of 64 bits as a float writes the next number.
        const bool isInRange = number >= static_cast<double>(Limits::min()) &&
          number <= static_cast<double>(Limits::max());
        if (isFloat || (isInRange && !fill.is_number_integer()))
        {
          value = CutToRange<T>(number);
        }
        else if (const auto whole = FindWhole<T>(fill))
        {
          value = *whole;
        }
        else
        {
          return false;
        }
        std::memcpy(this->Metadata.Fill.data(), &value, sizeof(T));
        return true;
      });
    return isPossible ? Status::Ok() : this->Corrupt("have a fill value beyond the data type");
  }

  /// The bits of a float, as "0x7fc00000".
  Status StoreBits(const std::string& hex)
  {
    const std::size_t digits = 2 * (this->Metadata.IsHalf ? 2 : GetValueSize(this->Metadata.Type));
    if (hex.size() != 2 + digits ||
      hex.find_first_not_of("0123456789abcdefABCDEF", 2) != std::string::npos)
    {
      return this->Corrupt("have a fill value of the wrong number of bits");
    }
    const std::uint64_t bits = std::stoull(hex, nullptr, 16);
    if (this->Metadata.IsHalf)
    {
      const float value = WidenHalf(static_cast<std::uint16_t>(bits));
      std::memcpy(this->Metadata.Fill.data(), &value, sizeof(value));
      return Status::Ok();
    }
    for (std::size_t byte = 0; byte < digits / 2; ++byte)
    {
      this->Metadata.Fill[byte] = static_cast<std::uint8_t>(bits >> (8 * byte));
    }
    return Status::Ok();
  }

  Status AddCodec(const std::string& name, std::vector<ZarrCodec>& codecs)
  {
    const auto codec = FindZarrCodec(name);
    const Status loaded = codec ? LoadZarrCodec(*codec) : Status();
    if (!codec || !loaded.IsOk())
    {
      return this->Unsupported(
        codec ? loaded.GetMessage() : "its codec, " + name + ", is not known");
    }
    const auto isCompressor = [](ZarrCodec known) { return known != ZarrCodec::Crc32c; };
    if (codecs.size() >= MaximumCodecs)
    {
      return this->Unsupported(
        "its chunks have more than " + std::to_string(MaximumCodecs) + " codecs");
    }
    if (isCompressor(*codec) && std::any_of(codecs.begin(), codecs.end(), isCompressor))
    {
      return this->Unsupported("its chunks are compressed twice");
    }
    codecs.push_back(*codec);
    this->CodecNames += ", " + name;
    return Status::Ok();
  }

  void SetOrder(bool isReversed)
  {
    std::vector<std::size_t>& order = this->Metadata.Encoding.Order;
    order.resize(this->Metadata.Shape.size());
    std::iota(order.begin(), order.end(), std::size_t{ 0 });
    if (isReversed)
    {
      std::reverse(order.begin(), order.end());
    }
  }

  Status ParseSecond()
  {
    const Json& json = this->Node.Array;
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(json, "shape"), "shape", this->Metadata.Shape));
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(json, "chunks"), "chunks", this->Metadata.Chunk));
    this->Metadata.Shard = this->Metadata.Chunk;
    const std::string type = FindJsonText(json, "dtype");
    if (type.size() < 3)
    {
      return this->Unsupported("its data type is none of real numbers");
    }
    const std::string kind = type.substr(1, 1);
    const std::string size = type.substr(2);
    const std::string bits = size == "1" ? "8"
      : size == "2"                      ? "16"
      : size == "4"                      ? "32"
      : size == "8"                      ? "64"
                                         : "?";
    ISOSURFACE_RETURN_IF_ERROR(this->TakeType(kind == "i" ? "int" + bits
        : kind == "u"                                     ? "uint" + bits
        : kind == "f"                                     ? "float" + bits
        : type == "|b1"                                   ? "bool"
                                                          : type));
    this->Metadata.Encoding.IsBigEndian = type[0] == '>';
    this->SetOrder(FindJsonText(json, "order", "C") == "F");
    ISOSURFACE_RETURN_IF_ERROR(this->TakeFill(FindJson(json, "fill_value")));
    const Json& filters = FindJson(json, "filters");
    if (filters.is_array() && !filters.empty())
    {
      return this->Unsupported(
        "its filter, " + FindJsonText(filters[0], "id", "?") + ", is not known");
    }
    if (FindJson(json, "compressor").is_object())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->AddCodec(
        FindJsonText(FindJson(json, "compressor"), "id", "?"), this->Metadata.Encoding.Codecs));
    }
    ISOSURFACE_RETURN_IF_ERROR(this->TakeSeparator(FindJsonText(json, "dimension_separator", ".")));
    this->Metadata.HasSeparator = json.contains("dimension_separator");
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNames(FindJson(this->Node.Attributes, "_ARRAY_DIMENSIONS")));
    return Status::Ok();
  }

  /// Of the numbers in the name of a chunk; both versions know two.
  Status TakeSeparator(const std::string& separator)
  {
    if (separator != "." && separator != "/")
    {
      return this->Corrupt("separate the numbers of chunks by neither \".\" nor \"/\"");
    }
    this->Metadata.Separator = separator;
    return Status::Ok();
  }

  Status TakeNames(const Json& names)
  {
    if (!names.is_null() && (!names.is_array() || names.size() != this->Metadata.Shape.size()))
    {
      return this->Corrupt("do not name each axis");
    }
    for (const Json& name : names)
    {
      this->Metadata.DimensionNames.push_back(GetJsonText(name));
    }
    return Status::Ok();
  }

  Status ParseThird()
  {
    const Json& json = this->Node.Array;
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(json, "shape"), "shape", this->Metadata.Shape));
    const Json& grid = FindJson(json, "chunk_grid");
    if (FindJsonText(grid, "name") != "regular")
    {
      return this->Unsupported("its chunk grid is not regular");
    }
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(FindJson(grid, "configuration"), "chunk_shape"), "chunk_shape",
        this->Metadata.Chunk));
    this->Metadata.Shard = this->Metadata.Chunk;
    ISOSURFACE_RETURN_IF_ERROR(this->TakeType(FindJsonText(json, "data_type", "an extension")));
    ISOSURFACE_RETURN_IF_ERROR(this->TakeFill(FindJson(json, "fill_value")));
    const std::string known =
      " zarr_format node_type shape data_type chunk_grid chunk_key_encoding "
      "fill_value codecs attributes storage_transformers dimension_names "
      "consolidated_metadata ";
    for (const auto& [name, member] : json.items())
    {
      const Json& isNeeded = FindJson(member, "must_understand");
      if (known.find(" " + name + " ") == std::string::npos && isNeeded != Json(false))
      {
        return this->Unsupported("it has \"" + name + "\", which is not known");
      }
    }
    const Json& transformers = FindJson(json, "storage_transformers");
    if (transformers.is_array() && !transformers.empty())
    {
      return this->Unsupported("it has storage transformers");
    }
    const Json& keys = FindJson(json, "chunk_key_encoding");
    const std::string encoding = FindJsonText(keys, "name", "default");
    if (encoding != "default" && encoding != "v2")
    {
      return this->Unsupported("its chunk key encoding, " + encoding + ", is not known");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->TakeSeparator(
      FindJsonText(FindJson(keys, "configuration"), "separator", encoding == "v2" ? "." : "/")));
    this->Metadata.KeyPrefix = encoding == "v2" ? "" : "c" + this->Metadata.Separator;
    ISOSURFACE_RETURN_IF_ERROR(this->TakeNames(FindJson(json, "dimension_names")));
    this->SetOrder(false);
    return this->TakeCodecs(FindJson(json, "codecs"), true);
  }

  /// The list of codecs of a chunk, or of the chunks in a shard.
  Status TakeCodecs(const Json& codecs, bool mayShard)
  {
    if (!codecs.is_array() || codecs.empty())
    {
      return this->Corrupt("have no codecs");
    }
    bool isBytes = false;
    for (const Json& codec : codecs)
    {
      const std::string name =
        codec.is_string() ? codec.get<std::string>() : FindJsonText(codec, "name", "?");
      const Json& settings = FindJson(codec, "configuration");
      if (name == "sharding_indexed" && !isBytes && mayShard && codecs.size() == 1)
      {
        return this->TakeShards(settings);
      }
      if (name == "transpose" && !isBytes)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->TakeTranspose(FindJson(settings, "order")));
      }
      else if (name == "bytes" && !isBytes)
      {
        isBytes = true;
        this->Metadata.Encoding.IsBigEndian = FindJsonText(settings, "endian") == "big";
      }
      else if (isBytes)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->AddCodec(name, this->Metadata.Encoding.Codecs));
      }
      else
      {
        return this->Unsupported("its codec, " + name + ", is not known, or not in this place");
      }
    }
    return isBytes ? Status::Ok() : this->Corrupt("have no codec to bytes");
  }

  Status TakeTranspose(const Json& order)
  {
    Numbers numbers;
    ISOSURFACE_RETURN_IF_ERROR(this->TakeNumbers(order, "order of axes", numbers));
    std::vector<std::size_t>& to = this->Metadata.Encoding.Order;
    const std::vector<std::size_t> before = to;
    Numbers sorted = numbers;
    std::sort(sorted.begin(), sorted.end());
    Numbers axes(before.size());
    std::iota(axes.begin(), axes.end(), std::int64_t{ 0 });
    if (sorted != axes)
    {
      return this->Corrupt("have an impossible order of axes");
    }
    for (std::size_t axis = 0; axis < numbers.size(); ++axis)
    {
      to[axis] = before[static_cast<std::size_t>(numbers[axis])];
    }
    return Status::Ok();
  }

  Status TakeShards(const Json& settings)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(settings, "chunk_shape"), "chunk_shape", this->Metadata.Chunk));
    this->Metadata.HasShards = true;
    this->Metadata.IsIndexAtStart = FindJsonText(settings, "index_location", "end") == "start";
    const Json& codecs = FindJson(settings, "index_codecs");
    if (!codecs.is_array())
    {
      return this->Corrupt("have no index_codecs");
    }
    const std::string names = this->CodecNames;
    for (const Json& codec : codecs)
    {
      const std::string name = FindJsonText(codec, "name", "?");
      if (name == "bytes")
      {
        this->Metadata.IsIndexBigEndian =
          FindJsonText(FindJson(codec, "configuration"), "endian") == "big";
      }
      else if (name == "crc32c" && this->Metadata.IndexCodecs.size() < MaximumCodecs)
      {
        this->Metadata.IndexCodecs.push_back(ZarrCodec::Crc32c);
      }
      else
      {
        return this->Unsupported("the codec of its index, " + name + ", has no fixed size");
      }
    }
    return this->TakeCodecs(FindJson(settings, "codecs"), false);
  }

  Status ParseN5()
  {
    const Json& json = this->Node.Array;
    this->Metadata.IsN5 = true;
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(json, "dimensions"), "dimensions", this->Metadata.Shape));
    ISOSURFACE_RETURN_IF_ERROR(
      this->TakeNumbers(FindJson(json, "blockSize"), "blockSize", this->Metadata.Chunk));
    std::reverse(this->Metadata.Shape.begin(), this->Metadata.Shape.end());
    std::reverse(this->Metadata.Chunk.begin(), this->Metadata.Chunk.end());
    this->Metadata.Shard = this->Metadata.Chunk;
    ISOSURFACE_RETURN_IF_ERROR(this->TakeType(FindJsonText(json, "dataType", "?")));
    this->SetOrder(false);
    this->Metadata.Encoding.IsBigEndian = true;
    this->Metadata.Separator = "/";
    const Json& compression = FindJson(json, "compression");
    const std::string codec =
      FindJsonText(compression, "type", FindJsonText(json, "compressionType", "raw"));
    // LZ4 of N5 has frames of its own, which numcodecs does not have.
    return codec == "raw" ? Status::Ok()
      : codec == "lz4"    ? this->Unsupported("its codec, lz4 of N5, is not known")
                          : this->AddCodec(codec, this->Metadata.Encoding.Codecs);
  }

  const ZarrNode& Node;
  std::string Folder;
  ZarrMetadata Metadata;
  std::string CodecNames;
};

} // namespace

Result<ZarrMetadata> ParseZarrMetadata(const ZarrNode& node, const std::string& folder)
{
  return ZarrParser(node, folder).Parse();
}

} // namespace isosurface
