// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockedVolumeHeader.h"

#include "Fixtures/Require.h"
#include "Storage/Store/JsonDocument.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <functional>
#include <limits>

using namespace isosurface;

namespace
{

const std::string Path = "/data/a.bvol";

BlockedVolumeHeader MakeHeader()
{
  BlockedVolumeHeader header;
  header.Grid.Extent = { -5, 44, 0, 9, 7, 7 };
  header.Grid.Origin = { 0.1, -1.0 / 3.0, 1e-300 };
  header.Grid.Spacing = { 1e30, 2.0 / 7.0, 5e-324 };
  header.Grid.Direction = { 0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1 };
  header.BlockSize = 16;
  header.NumberOfStores = 2;
  header.Distribution = DistributionMethod::Random;
  header.RandomSeed = std::numeric_limits<std::uint64_t>::max();
  header.Arrays = { { "a", ValueType::Int64 }, { "b", ValueType::Float32 },
    { "c", ValueType::UInt64 }, { "", ValueType::Float64 } };
  TimeStepDescription step;
  step.Time = 0.3;
  step.Folder = "000012";
  const auto range = [](auto low, auto high) {
    return KeyRange{ MakeValueKey(low), MakeValueKey(high) };
  };
  step.Ranges = { range(std::numeric_limits<std::int64_t>::min(),
                    std::numeric_limits<std::int64_t>::max() - 1),
    range(-0.1f, std::numeric_limits<float>::max()),
    range(std::uint64_t{ 3 }, (std::uint64_t{ 1 } << 63) + 1), KeyRange{} };
  step.Stores = { { 3, 8192, 0xFEDCBA9876543210u }, { 1, 4096, 7 } };
  header.TimeSteps = { step };
  step.Time = 1e300;
  step.Folder = "1000000";
  header.TimeSteps.push_back(step);
  return header;
}

/// A header's text after a change, with a right checksum.
std::string Change(const std::function<void(Json&)>& change)
{
  Json document = Json::parse(MakeHeader().Format());
  change(document);
  return FormatDocument(document);
}

void ExpectRefused(
  const std::string& text, const std::string& part, StatusCode code = StatusCode::Corrupt)
{
  const auto header = BlockedVolumeHeader::Parse(text, Path);
  ASSERT_FALSE(header.IsOk()) << part;
  EXPECT_EQ(header.GetStatus().GetCode(), code) << header.GetStatus().GetMessage();
  EXPECT_EQ(header.GetStatus().GetMessage().find(Path), 0u) << header.GetStatus().GetMessage();
  EXPECT_NE(header.GetStatus().GetMessage().find(part), std::string::npos)
    << header.GetStatus().GetMessage() << " does not name " << part;
}

} // namespace

TEST(BlockedVolumeHeader, RoundTripsExactly)
{
  const BlockedVolumeHeader header = MakeHeader();
  const std::string text = header.Format();
  const auto parsed = Require(BlockedVolumeHeader::Parse(text, Path));
  EXPECT_EQ(parsed.Format(), text);
  EXPECT_EQ(parsed.Grid, header.Grid);
  EXPECT_EQ(parsed.RandomSeed, header.RandomSeed);
  for (std::size_t step = 0; step < 2; ++step)
  {
    EXPECT_EQ(parsed.TimeSteps[step].Time, header.TimeSteps[step].Time);
    for (std::size_t array = 0; array < 4; ++array)
    {
      EXPECT_EQ(
        parsed.TimeSteps[step].Ranges[array].Minimum, header.TimeSteps[step].Ranges[array].Minimum);
      EXPECT_EQ(
        parsed.TimeSteps[step].Ranges[array].Maximum, header.TimeSteps[step].Ranges[array].Maximum);
    }
    EXPECT_EQ(parsed.TimeSteps[step].Stores[0].Checksum, 0xFEDCBA9876543210u);
  }
}

TEST(BlockedVolumeHeader, RefusesMoreReplicasThanCanBeChecked)
{
  BlockedVolumeHeader header = MakeHeader();
  header.Grid.Extent = { 0, 16000, 0, 16000, 0, 160 };
  header.NumberOfStores = 1U << 20;
  EXPECT_TRUE(header.ValidateVolume().IsOk());
  header.NumberOfReplicas = 2;
  ExpectMessage(header.ValidateVolume(), "above 2^20");
  header.NumberOfStores = 1U << 19;
  EXPECT_TRUE(header.ValidateVolume().IsOk());
}

TEST(BlockedVolumeHeader, NamesReplicasOnlyIfThereAreSome)
{
  BlockedVolumeHeader header = MakeHeader();
  EXPECT_EQ(header.Format().find("replicas"), std::string::npos);
  header.NumberOfReplicas = 2;
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.NumberOfReplicas, 2u);
  EXPECT_EQ(parsed.Format(), header.Format());
  MemoryDisk disk;
  EXPECT_EQ(
    GetReplicaFolder(disk, "/a.bvol", "000001", 1, 0, 2), "/.a.bvol.stores/000001/store-00001");
  EXPECT_EQ(GetReplicaFolder(disk, "/a.bvol", "000001", 1, 1, 2),
    "/.a.bvol.stores/000001/store-00000/replica-1");
}

TEST(BlockedVolumeHeader, HasARangeOfEachComponentAndOfEachMagnitude)
{
  BlockedVolumeHeader header = MakeHeader();
  header.Arrays[1].Components = 3;
  const KeyRange floats = { MakeValueKey(-2.5f), MakeValueKey(1.5f) };
  const KeyRange magnitudes = { MakeValueKey(0.1), MakeValueKey(4.25) };
  for (TimeStepDescription& step : header.TimeSteps)
  {
    step.Ranges.insert(step.Ranges.begin() + 2, { KeyRange{}, floats });
    step.Ranges.push_back(magnitudes);
  }
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.Format(), header.Format());
  EXPECT_EQ(parsed.Arrays[1].Components, 3);
  ASSERT_EQ(parsed.TimeSteps[0].Ranges.size(), 7u);
  EXPECT_TRUE(parsed.TimeSteps[0].Ranges[2].IsEmpty());
  EXPECT_EQ(parsed.TimeSteps[0].Ranges[3].Minimum, floats.Minimum);
  EXPECT_EQ(parsed.TimeSteps[0].Ranges[6].Maximum, magnitudes.Maximum);

  const ArrayVariables variables = parsed.GetVariables();
  ASSERT_EQ(variables.GetCount(), 7u);
  EXPECT_EQ(variables.GetNumberOfStored(), 6u);
  EXPECT_EQ(variables.Find(1, 2), std::size_t{ 3 });
  EXPECT_EQ(variables.Find(2, 0), std::size_t{ 4 });
  EXPECT_EQ(variables.Find(1, Variable::Magnitude), std::size_t{ 6 });
  EXPECT_EQ(variables.Find(2, Variable::Magnitude), std::size_t{ 4 });
  EXPECT_EQ(variables.FindChoice(1, 3), std::size_t{ 6 });
  EXPECT_EQ(variables.FindChoice(2, 3), std::size_t{ 4 });
  EXPECT_FALSE(variables.Find(1, 3).has_value());
  EXPECT_FALSE(variables.FindChoice(1, 4).has_value());
  EXPECT_FALSE(variables.FindChoice(1, -1).has_value());
  EXPECT_FALSE(variables.Find(4, 0).has_value());
}

TEST(BlockedVolumeHeader, HoldsManyStores)
{
  // So many that looking at all of them after each one would be felt.
  BlockedVolumeHeader header = MakeHeader();
  header.NumberOfStores = 1u << 16;
  header.Grid.Extent = { 0, 16 << 16, 0, 9, 7, 7 };
  header.TimeSteps.pop_back();
  header.TimeSteps[0].Stores.clear();
  for (std::uint64_t store = 0; store < header.NumberOfStores; ++store)
  {
    header.TimeSteps[0].Stores.push_back({ 1, 4096, store });
  }
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.TimeSteps[0].Stores.back().Checksum, header.NumberOfStores - 1);
}

TEST(BlockedVolumeHeader, RefusesMoreStoresThanTheVolumeCanUse)
{
  BlockedVolumeHeader header = MakeHeader();
  header.TimeSteps.pop_back();
  for (const std::uint32_t stores : { 4096u, 4097u })
  {
    header.NumberOfStores = stores;
    header.TimeSteps[0].Stores.resize(2);
    header.TimeSteps[0].Stores.resize(stores, { 0, 0, 1 });
    const auto parsed = BlockedVolumeHeader::Parse(header.Format(), Path);
    EXPECT_EQ(parsed.IsOk(), stores == 4096u);
    EXPECT_NE(parsed.GetStatus().GetMessage().find(stores == 4096u ? "" : "number of stores"),
      std::string::npos)
      << parsed.GetStatus().GetMessage();
  }
}

TEST(BlockedVolumeHeader, RefusesWhatItsChecksumDoesNotCover)
{
  const std::string text = MakeHeader().Format();
  const std::string end = "\n}\n";
  ASSERT_EQ(text.substr(text.size() - 3), end);
  const std::string covered = text.substr(0, text.size() - 3);
  for (const std::string& other : { std::string("\n}"), std::string(" }"), std::string("}\r\n") })
  {
    EXPECT_TRUE(BlockedVolumeHeader::Parse(covered + other, Path).IsOk()) << other;
  }
  for (const std::string& other : { std::string(",\"stores\":2}\n"), std::string("\n}\n\n"),
         std::string("\n}\n "), std::string("\n}\n") + '\0' + "x", std::string("\n}\n{}") })
  {
    const auto parsed = BlockedVolumeHeader::Parse(covered + other, Path);
    EXPECT_EQ(parsed.GetStatus().GetCode(), StatusCode::Corrupt) << other;
  }
}

TEST(BlockedVolumeHeader, StatesTheCompression)
{
  BlockedVolumeHeader header = MakeHeader();
  header.Compression = { SegmentCodec::Zstd, 7 };
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.Compression.Codec, SegmentCodec::Zstd);
  EXPECT_EQ(parsed.Compression.Level, 7);
  EXPECT_EQ(parsed.Format(), header.Format());
}

TEST(BlockedVolumeHeader, HasTheUnitOfAnArrayOnlyIfItIsKnown)
{
  BlockedVolumeHeader header = MakeHeader();
  EXPECT_EQ(header.Format().find("\"unit\""), std::string::npos);
  header.Arrays[0].Unit = "HU";
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.Arrays[0].Unit, "HU");
  EXPECT_EQ(parsed.Arrays[1].Unit, "");
  header.Arrays[0].Unit = "\xFF";
  EXPECT_EQ(header.ValidateVolume().GetCode(), StatusCode::InvalidArgument);
}

TEST(BlockedVolumeHeader, HasTheUnitOfLengthOnlyIfItIsKnown)
{
  BlockedVolumeHeader header = MakeHeader();
  header.Grid.Unit = LengthUnit::Micrometer;
  EXPECT_NE(header.Format().find("\"unit\": \"um\""), std::string::npos);
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.Grid.Unit, LengthUnit::Micrometer);
  EXPECT_EQ(parsed.Format(), header.Format());
  const auto other = Change([](Json& document) { document["grid"]["unit"] = "parsec"; });
  EXPECT_EQ(Require(BlockedVolumeHeader::Parse(other, Path)).Grid.Unit, LengthUnit::Unknown);
  ExpectRefused(Change([](Json& document) { document["grid"]["unit"] = 3; }), "grid.unit");
}

TEST(BlockedVolumeHeader, IgnoresMembersItDoesNotKnow)
{
  const auto header = BlockedVolumeHeader::Parse(Change(
                                                   [](Json& document)
                                                   {
                                                     document["comment"] = { 1, 2, 3 };
                                                     document["arrays"][0]["history"] = "none";
                                                     document["timeSteps"][0]["stores"][0]["host"] =
                                                       nullptr;
                                                   }),
    Path);
  EXPECT_TRUE(header.IsOk()) << header.GetStatus().GetMessage();
}

TEST(BlockedVolumeHeader, RefusesANewerVersionWithAdvice)
{
  ExpectRefused(Change([](Json& document) { document["formatVersion"] = 2; }), "update",
    StatusCode::Unsupported);
  ExpectRefused(Change([](Json& document) { document["compression"] = "brotli"; }), "brotli",
    StatusCode::Unsupported);
}

TEST(BlockedVolumeHeader, NamesWhatIsWrong)
{
  const Json huge = Json::parse("18446744073709551615");
  const std::pair<const char*, std::function<void(Json&)>> changes[] = {
    { "format", [](Json& d) { d["format"] = "other"; } },
    { "formatVersion", [](Json& d) { d["formatVersion"] = "1"; } },
    { "formatVersion", [](Json& d) { d.erase("formatVersion"); } },
    { "grid.extent", [](Json& d) { d["grid"].erase("extent"); } },
    { "grid.extent",
      [](Json& d) {
        d["grid"]["extent"] = { 0, 1, 0, 1, 0 };
      } },
    { "grid.extent", [](Json& d) { d["grid"]["extent"][0] = 1.5; } },
    { "grid.extent", [&](Json& d) { d["grid"]["extent"][1] = huge; } },
    { "the grid is empty",
      [](Json& d) {
        d["grid"]["extent"] = { 0, -1, 0, 1, 0, 1 };
      } },
    { "the grid has more than 2^60 vertices",
      [](Json& d) {
        d["grid"]["extent"] = { 0, 1LL << 39, 0, 1LL << 39, 0, 1LL << 39 };
      } },
    { "grid.origin", [](Json& d) { d["grid"]["origin"][2] = "x"; } },
    { "grid.spacing", [](Json& d) { d["grid"]["spacing"] = nullptr; } },
    { "grid has a spacing of 0", [](Json& d) { d["grid"]["spacing"][1] = 0; } },
    { "grid has a spacing of 0", [](Json& d) { d["grid"]["spacing"][2] = -0.0; } },
    { "grid has directions that lie in a plane",
      [](Json& d) {
        d["grid"]["direction"] = { 1, 0, 1, 0, 1, 1, 0, 0, 0 };
      } },
    { "grid has directions that lie in a plane",
      [](Json& d) {
        d["grid"]["direction"] = { 1, 2, 3, 4, 5, 6, 7, 8, 9 };
      } },
    { "grid.", [](Json& d) { d["grid"] = 5; } },
    { "blockSize", [](Json& d) { d["blockSize"] = 48; } },
    { "blockSize", [](Json& d) { d["blockSize"] = -16; } },
    { "the grid has more than 2^32 blocks",
      [](Json& d) {
        d["grid"]["extent"] = { 0, 1LL << 24, 0, 1LL << 24, 0, 3000 };
      } },
    { "ghostLayers", [](Json& d) { d["ghostLayers"] = 2; } },
    { "numberOfLevels", [](Json& d) { d["numberOfLevels"] = 6; } },
    { "stores", [](Json& d) { d["stores"] = 0; } },
    { "stores", [](Json& d) { d["stores"] = 4000000000u; } },
    { "timeSteps[0].stores", [](Json& d) { d["stores"] = 3; } },
    { "replicas", [](Json& d) { d["replicas"] = 0; } },
    { "replicas", [](Json& d) { d["replicas"] = -1; } },
    { "replicas", [](Json& d) { d["replicas"] = 17; } },
    { "replicas", [](Json& d) { d["replicas"] = "2"; } },
    { "replicas", [](Json& d) { d["replicas"] = 1.5; } },
    { "3 replicas take as many stores; there are 2", [](Json& d) { d["replicas"] = 3; } },
    { "compression", [](Json& d) { d["compression"] = 3; } },
    { "compressionLevel", [](Json& d) { d["compression"] = "lz4"; } },
    { "the compression level is beyond",
      [](Json& d)
      {
        d["compression"] = "lz4";
        d["compressionLevel"] = 13;
      } },
    { "distribution.method", [](Json& d) { d["distribution"]["method"] = "best"; } },
    { "distribution.seed", [](Json& d) { d["distribution"]["seed"] = -1; } },
    { "arrays", [](Json& d) { d["arrays"] = Json::object(); } },
    { "arrays[1].type", [](Json& d) { d["arrays"][1]["type"] = "float16"; } },
    { "arrays[0].components", [](Json& d) { d["arrays"][0]["components"] = 0; } },
    { "arrays[0].components", [](Json& d) { d["arrays"][0]["components"] = 1.5; } },
    { "arrays[0].components", [&](Json& d) { d["arrays"][0]["components"] = huge; } },
    // Together they are more than a page of the directory takes on one level.
    { "arrays[1].components", [](Json& d) { d["arrays"][0]["components"] = 4090; } },
    // 815 and three others, of 5 levels each, are as many as a page of the directory takes.
    { "timeSteps[0].ranges", [](Json& d) { d["arrays"][0]["components"] = 815; } },
    { "arrays",
      [](Json& d)
      {
        d["arrays"][0]["components"] = 816;
        for (Json& step : d["timeSteps"])
        {
          step["ranges"] = std::vector<Json>(820);
        }
      } },
    { "timeSteps[0].ranges", [](Json& d) { d["arrays"][0]["components"] = 2; } },
    { "timeSteps[0].ranges", [](Json& d) { d["timeSteps"][0]["ranges"].push_back(nullptr); } },
    { "timeSteps[].time", [](Json& d) { d["timeSteps"][1]["time"] = nullptr; } },
    { "timeSteps[].time", [](Json& d) { d["timeSteps"][0]["time"] = nullptr; } },
    { "timeSteps[].time", [](Json& d) { d["timeSteps"][1]["time"] = 0.3; } },
    { "timeSteps[].time", [](Json& d) { d["timeSteps"][1]["time"] = -4; } },
    { "two arrays have the name \"a\"", [](Json& d) { d["arrays"][1]["name"] = "a"; } },
    { "timeSteps", [](Json& d) { d["timeSteps"] = Json::array(); } },
    { "timeSteps[1].folder", [](Json& d) { d["timeSteps"][1]["folder"] = 7; } },
    { "timeSteps[].folder", [](Json& d) { d["timeSteps"][1]["folder"] = "../../etc"; } },
    { "timeSteps[0].time", [](Json& d) { d["timeSteps"][0]["time"] = "now"; } },
    { "timeSteps[0].ranges",
      [](Json& d) {
        d["timeSteps"][0]["ranges"][0] = { 5, 4 };
      } },
    { "timeSteps[0].ranges",
      [](Json& d) {
        d["timeSteps"][0]["ranges"][2] = { -1, 4 };
      } },
    { "timeSteps[0].ranges",
      [](Json& d) {
        d["timeSteps"][0]["ranges"][1] = { 0, 1e39 };
      } },
    { "timeSteps[0].stores[1].checksum",
      [](Json& d) { d["timeSteps"][0]["stores"][1]["checksum"] = "12"; } },
    { "timeSteps[].stores", [](Json& d) { d["timeSteps"][0]["stores"][1]["blocks"] = 2; } },
    { "timeSteps[].stores", [&](Json& d) { d["timeSteps"][0]["stores"][1]["blocks"] = huge; } },
    { "timeSteps[].stores", [](Json& d) { d["timeSteps"][0]["stores"][1]["bytes"] = 4097; } },
  };
  for (const auto& change : changes)
  {
    SCOPED_TRACE(change.first);
    ExpectRefused(Change(change.second), change.first);
  }
}

namespace
{

/// A volume of 50 x 10 x 1 vertices in blocks of 16, four of them; an overview of two blocks, and
/// one of a single one.
BlockedVolumeHeader MakeHeaderWithOverviews()
{
  BlockedVolumeHeader header = MakeHeader();
  header.NumberOfLevels = 1;
  header.Overviews = { { 2, 2 }, { 5, 1 } };
  for (TimeStepDescription& step : header.TimeSteps)
  {
    step.Overviews = { { { 1, 4096, 8 }, { 1, 8192, 9 } }, { { 1, 4096, 10 } } };
  }
  return header;
}

std::string ChangeOverviews(const std::function<void(Json&)>& change)
{
  Json document = Json::parse(MakeHeaderWithOverviews().Format());
  change(document);
  return FormatDocument(document);
}

} // namespace

TEST(BlockedVolumeHeader, RoundTripsOverviewsAndGivesTheirGrids)
{
  const BlockedVolumeHeader header = MakeHeaderWithOverviews();
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), Path));
  EXPECT_EQ(parsed.Format(), header.Format());
  ASSERT_EQ(parsed.Overviews.size(), 2u);
  const BlockedVolumeHeader first = parsed.MakeOverview(0);
  EXPECT_EQ(first.Grid, header.Grid.Coarsen(1));
  EXPECT_EQ(first.GetBlockGrid().GetNumberOfBlocks(), 2);
  EXPECT_EQ(first.GetBlockGrid().GetNumberOfLevels(), 2);
  EXPECT_EQ(first.TimeSteps[1].Folder, "1000000/overview-1");
  EXPECT_EQ(first.TimeSteps[1].Stores[1].Checksum, 9u);
  const BlockedVolumeHeader second = parsed.MakeOverview(1);
  EXPECT_EQ(second.Grid, header.Grid.Coarsen(3));
  EXPECT_EQ(second.GetBlockGrid().GetNumberOfBlocks(), 1);
  EXPECT_EQ(second.TimeSteps[0].Folder, "000012/overview-2");
}

TEST(BlockedVolumeHeader, HasVersionOneAndItsOverviewsEvenIfThereAreNone)
{
  const Json document = Json::parse(MakeHeader().Format());
  EXPECT_EQ(document["formatVersion"], 1);
  EXPECT_EQ(document["overviews"], Json::array());
  EXPECT_EQ(document["timeSteps"][0]["overviews"], Json::array());
  ExpectRefused(Change([](Json& d) { d.erase("overviews"); }), "overviews");
  ExpectRefused(
    Change([](Json& d) { d["timeSteps"][1].erase("overviews"); }), "timeSteps[1].overviews");
}

TEST(BlockedVolumeHeader, NamesTheMemberOfAnOverviewThatIsWrong)
{
  const Json one = Json::parse(R"({ "numberOfLevels": 1, "stores": 1 })");
  const Json stores = Json::parse(
    R"({ "stores": [ { "blocks": 1, "bytes": 4096, "checksum": "0000000000000000" } ] })");
  const std::pair<const char*, std::function<void(Json&)>> changes[] = {
    { "overviews", [](Json& d) { d.erase("overviews"); } },
    { "overviews", [](Json& d) { d["overviews"] = 5; } },
    { "overviews[1]", [](Json& d) { d["overviews"][1] = 5; } },
    { "overviews[0].numberOfLevels", [](Json& d) { d["overviews"][0]["numberOfLevels"] = 0; } },
    { "overviews[1].numberOfLevels", [](Json& d) { d["overviews"][1]["numberOfLevels"] = 6; } },
    { "overviews[1].stores", [](Json& d) { d["overviews"][1]["stores"] = 0; } },
    // An overview has a single store.
    { "replicas", [](Json& d) { d["replicas"] = 2; } },
    { "numberOfLevels", [](Json& d) { d["numberOfLevels"] = 0; } },
    { "numberOfLevels", [](Json& d) { d["numberOfLevels"] = -1; } },
    // The overviews would be coarser than their blocks say.
    { "timeSteps[].overviews", [](Json& d) { d["numberOfLevels"] = 2; } },
    { "timeSteps[0].overviews", [](Json& d) { d["timeSteps"][0].erase("overviews"); } },
    { "timeSteps[0].overviews", [](Json& d) { d["timeSteps"][0]["overviews"].erase(1); } },
    { "timeSteps[1].overviews[0].stores",
      [](Json& d) { d["timeSteps"][1]["overviews"][0]["stores"].erase(1); } },
    { "timeSteps[1].overviews[0].stores[0].checksum",
      [](Json& d) { d["timeSteps"][1]["overviews"][0]["stores"][0]["checksum"] = 4; } },
    { "timeSteps[].overviews",
      [](Json& d) { d["timeSteps"][1]["overviews"][0]["stores"][0]["blocks"] = 2; } },
    { "timeSteps[].overviews",
      [](Json& d) { d["timeSteps"][1]["overviews"][1]["stores"][0]["bytes"] = 5; } },
    // Nested without an end.
    { "overviews",
      [&](Json& d)
      {
        for (int more = 0; more < 1000; ++more)
        {
          d["overviews"].push_back(one);
          for (Json& step : d["timeSteps"])
          {
            step["overviews"].push_back(stores);
          }
        }
      } },
  };
  for (const auto& change : changes)
  {
    SCOPED_TRACE(change.first);
    ExpectRefused(ChangeOverviews(change.second), change.first);
  }
}

TEST(BlockedVolumeHeader, RefusesDamagedText)
{
  const std::string text = MakeHeader().Format();
  for (std::size_t size = 0; size + 2 < text.size(); size += 7)
  {
    ExpectRefused(text.substr(0, size), "");
  }
  for (std::size_t position = 0; position < text.size(); ++position)
  {
    std::string damaged = text;
    damaged[position] = static_cast<char>(damaged[position] ^ 4);
    const auto header = BlockedVolumeHeader::Parse(damaged, Path);
    // White space alone may change without harm.
    EXPECT_TRUE(!header.IsOk() || header->Format() == text) << position;
  }
  ExpectRefused(std::string(10000000, '['), "");
  const std::string quotes = Change([](Json& d) { d["comment"] = std::string(40, '[') + "\\\"{"; });
  EXPECT_TRUE(BlockedVolumeHeader::Parse(quotes, Path).IsOk()) << "brackets in a string";
  std::string deep = "{\"a\":";
  for (int depth = 0; depth < 100000; ++depth)
  {
    deep += "{\"a\":";
  }
  ExpectRefused(deep + "1" + std::string(100001, '}'), "");
  ExpectRefused("[]", "");
  ExpectRefused("\xff\xfe", "");
}
