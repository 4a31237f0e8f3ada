// SPDX-License-Identifier: BSD-3-Clause
// What metadata may cost. Samples and everything else: Testing/Tools/check_zarr.py.
#include "Fixtures/SampleFiles.h"

#include "Formats/Opener/ForeignVolume.h"

#include <cstring>
#include <limits>
#include <sstream>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

const std::string Folder = "/data/a.zarr";

std::string Repeat(const std::string& text, std::size_t count)
{
  std::string all;
  for (std::size_t n = 0; n < count; ++n)
  {
    all += (n == 0 ? "" : ",") + text;
  }
  return all;
}

/// An array of Zarr 3 of one chunk, with more members.
std::string MakeArray(
  const std::string& codecs, const std::string& more = "", const std::string& separator = "/")
{
  return R"({"zarr_format": 3, "node_type": "array", "shape": [2, 2, 2], "data_type": "uint8",
    "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 2, 2]}},
    "chunk_key_encoding": {"name": "default", "configuration": {"separator": ")" +
    separator + R"("}}, "fill_value": 0, "codecs": [{"name": "bytes"}, )" + codecs + "]" + more +
    "}";
}

/// An image of multiscales with axes and channels.
std::string MakeImage(const std::string& axes, const std::string& channels)
{
  return R"({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"multiscales": [{
    "datasets": [{"path": "0"}], "axes": [)" +
    axes + R"(]}], "omero": {"channels": [)" + channels + "]}}}}";
}

std::string FindError(const std::string& json, const std::string& file = "/zarr.json")
{
  MemoryDisk disk;
  static_cast<void>(disk.MakeDirectories(Folder + "/0"));
  WriteFile(disk, Folder + file, MakeBytes(json));
  WriteFile(disk, Folder + "/0/zarr.json", MakeBytes(MakeArray(R"({"name": "crc32c"})")));
  const auto volume = OpenForeignVolume(disk, Folder);
  return volume.IsOk() ? "" : volume.GetStatus().GetMessage();
}

/// The first sample of an array of 2 x 2 x 2 without chunks, or the error.
template <typename T>
std::string ReadFill(const std::string& type, const std::string& fill)
{
  std::string json = MakeArray(R"({"name": "crc32c"})");
  json.replace(json.find("uint8"), 5, type);
  const std::string before = "\"fill_value\": ";
  json.replace(json.find(before), before.size() + 1, before + fill);
  MemoryDisk disk;
  static_cast<void>(disk.MakeDirectories(Folder));
  WriteFile(disk, Folder + "/zarr.json", MakeBytes(json));
  const auto volume = OpenForeignVolume(disk, Folder);
  if (!volume.IsOk())
  {
    return volume.GetStatus().GetMessage();
  }
  T value;
  std::memcpy(&value, Require(volume->Source->Read(volume->Source->GetBox())).Arrays.at(0).First,
    sizeof(value));
  std::ostringstream text;
  text << +value;
  return text.str();
}
template <typename T>
void ExpectMaximumOfFill(const std::string& type, const std::string& number)
{
  EXPECT_EQ(ReadFill<T>(type, number), std::to_string(std::numeric_limits<T>::max())) << type;
}

} // namespace

TEST(ZarrVolume, NestedMetadataOverflowsNoStack)
{
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  const std::string reason = ": cannot be read: it nests more than 64 objects";
  EXPECT_EQ(
    FindError(MakeArray(R"({"name": "crc32c"})", ", \"attributes\": {\"a\": " + deep + "}")),
    Folder + "/zarr.json" + reason);
  EXPECT_EQ(FindError("{\"a\": " + deep + "}", "/.zarray"), Folder + "/.zarray" + reason);
  EXPECT_EQ(
    FindError("{\"a\": " + deep + "}", "/attributes.json"), Folder + "/attributes.json" + reason);
  const std::string few = std::string(60, '[') + std::string(60, ']');
  EXPECT_EQ(
    FindError(MakeArray(R"({"name": "crc32c"})", ", \"attributes\": {\"a\": " + few + "}")), "");
}

TEST(ZarrVolume, CodecsAreFew)
{
  EXPECT_EQ(FindError(MakeArray(Repeat(R"({"name": "crc32c"})", 4))), "");
  EXPECT_NE(FindError(MakeArray(Repeat(R"({"name": "crc32c"})", 80000))).find("more than 4 codecs"),
    std::string::npos);
}

TEST(ZarrVolume, AxesAndChannelsAreFew)
{
  const std::string axes =
    R"({"name": "z", "type": "space"}, {"name": "y", "type": "space"}, {"name": "x", "type": "space"})";
  EXPECT_EQ(FindError(MakeImage(axes, R"({"label": "a"})")), "");
  EXPECT_NE(FindError(MakeImage(Repeat(R"({"name": "z", "unit": "u"})", 33), "")).find("33 axes"),
    std::string::npos);
  EXPECT_NE(FindError(MakeImage(axes, Repeat(R"({"label": "a"})", 1025))).find("1025 channels"),
    std::string::npos);
}

TEST(ZarrVolume, SeparatorsOfChunksLeadNowhereElse)
{
  EXPECT_EQ(FindError(MakeArray(R"({"name": "crc32c"})", "", ".")), "");
  EXPECT_NE(FindError(MakeArray(R"({"name": "crc32c"})", "", "/../../x/")).find("separate"),
    std::string::npos);
}

TEST(ZarrVolume, AShardOfOneChunkHasAnIndex)
{
  for (const bool isAtStart : { false, true })
  {
    SCOPED_TRACE(isAtStart ? "index at the start" : "index at the end");
    const std::string little = R"({"name": "bytes", "configuration": {"endian": "little"}})";
    MemoryDisk disk;
    static_cast<void>(disk.MakeDirectories(Folder + "/c/0/0"));
    std::string json = MakeArray("");
    json.replace(json.find(R"({"name": "bytes"}, )"), 19,
      R"({"name": "sharding_indexed", "configuration": {"chunk_shape": [2, 2, 2], "codecs": [)" +
        little + R"(], "index_codecs": [)" + little + R"(], "index_location": ")" +
        (isAtStart ? "start" : "end") + "\"}}");
    WriteFile(disk, Folder + "/zarr.json", MakeBytes(json));
    const Bytes samples = { 1, 2, 3, 4, 5, 6, 7, 8 };
    Bytes shard(16, 0); // where the chunk begins, and its size
    shard[0] = isAtStart ? 16 : 0;
    shard[8] = 8;
    shard.insert(isAtStart ? shard.end() : shard.begin(), samples.begin(), samples.end());
    WriteFile(disk, Folder + "/c/0/0/0", shard);
    const auto volume = OpenForeignVolume(disk, Folder);
    ASSERT_TRUE(volume.IsOk()) << volume.GetStatus().GetMessage();
    const auto read = volume->Source->Read(volume->Source->GetBox());
    ASSERT_TRUE(read.IsOk()) << read.GetStatus().GetMessage();
    EXPECT_EQ(std::memcmp(read->Arrays.at(0).First, samples.data(), samples.size()), 0);
  }
}

TEST(ZarrVolume, NumbersThatJsonDoesNotHaveAreReadAsPythonWritesThem)
{
  const std::string codec = R"({"name": "crc32c"})";
  const std::string numbers =
    R"({"a": NaN, "b": [-Infinity,Infinity], "c": "a \" NaN, \\", "d": {"e":NaN}})";
  EXPECT_EQ(FindError(MakeArray(codec, ", \"attributes\": " + numbers)), "");
  EXPECT_EQ(FindError(numbers, "/.zattrs"), "");
  for (const std::string bad : { "NaNs", "nan", "-NaN", "- Infinity", "Inf", "NaN NaN", "1NaN" })
  {
    EXPECT_EQ(FindError(R"({"a": )" + bad + "}", "/.zattrs"),
      Folder + "/.zattrs: cannot be read: it is no JSON object; truncated?")
      << bad;
  }
  EXPECT_EQ(ReadFill<float>("float32", "NaN"), ReadFill<float>("float32", "\"NaN\""));
  EXPECT_EQ(ReadFill<float>("float32", "-Infinity"), "-inf");
  EXPECT_EQ(ReadFill<double>("float64", "Infinity"), "inf");
}

TEST(ZarrVolume, AnArrayIsReadBesideFoldersWithDamagedMetadata)
{
  MemoryDisk disk;
  for (const std::string name : { "/a", "/b", "/c" })
  {
    static_cast<void>(disk.MakeDirectories(Folder + name));
  }
  WriteFile(disk, Folder + "/.zgroup", MakeBytes("{\"zarr_format\": 2}"));
  WriteFile(disk, Folder + "/a/.zattrs", MakeBytes("{\"a\": "));
  const std::string error = Folder + "/a/.zattrs: cannot be read: it is no JSON object; truncated?";
  EXPECT_EQ(OpenForeignVolume(disk, Folder).GetStatus().GetMessage(), error);
  WriteFile(disk, Folder + "/b/zarr.json", MakeBytes(MakeArray(R"({"name": "crc32c"})")));
  WriteFile(disk, Folder + "/c/zarr.json", MakeBytes("{"));
  const auto volume = OpenForeignVolume(disk, Folder);
  ASSERT_TRUE(volume.IsOk()) << volume.GetStatus().GetMessage();
  EXPECT_EQ(volume->Arrays.at(0).Name, "b");
  EXPECT_EQ(OpenForeignVolume(disk, Folder + ":a").GetStatus().GetMessage(), error);
  const auto list = Require(ListForeignVolumes(disk, Folder));
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].Storage, error);
  EXPECT_EQ(list[1].Shape, "2 x 2 x 2");
}

TEST(ZarrVolume, AFillValueMayBeTheMaximumOfItsTypeAsAFloat)
{
  ExpectMaximumOfFill<std::uint8_t>("uint8", "255.0");
  ExpectMaximumOfFill<std::int8_t>("int8", "127.0");
  ExpectMaximumOfFill<std::uint16_t>("uint16", "65535.0");
  ExpectMaximumOfFill<std::int32_t>("int32", "2147483647.0");
  ExpectMaximumOfFill<std::uint32_t>("uint32", "4294967295.0");
  ExpectMaximumOfFill<std::uint64_t>("uint64", "18446744073709551615");
  // The maximum of 64 bits is no double: the next one stands for it.
  ExpectMaximumOfFill<std::uint64_t>("uint64", "1.8446744073709552e19");
  ExpectMaximumOfFill<std::int64_t>("int64", "9.223372036854775807e18");
  EXPECT_EQ(ReadFill<std::int64_t>("int64", "-9.223372036854775808e18"),
    std::to_string(std::numeric_limits<std::int64_t>::min()));
  for (const auto& [type, number] :
    std::vector<std::pair<std::string, std::string>>{ { "uint8", "255.5" }, { "uint8", "256.0" },
      { "uint8", "-1.0" }, { "int16", "32768.0" }, { "uint64", "1.8446744073709556e19" },
      { "int64", "9.223372036854778e18" }, { "uint8", "NaN" } })
  {
    EXPECT_EQ(ReadFill<std::uint8_t>(type, number),
      Folder + ": cannot be read: its metadata have a fill value beyond the data type")
      << type << " " << number;
  }
}
