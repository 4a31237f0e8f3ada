// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoreLists.h"

#include "Fixtures/Require.h"
#include "Ground/Base/Checksum.h"
#include "Storage/Store/JsonDocument.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace isosurface;

namespace
{

const std::string Path = "/data/a.bvol";

/// Two time steps of a volume of four blocks, with seals in the first one, and an overview.
BlockedVolumeHeader MakeHeaderOfLists(const std::string& arrayName)
{
  BlockedVolumeHeader header;
  header.Grid.Extent = { 0, 49, 0, 9, 7, 7 };
  header.BlockSize = 16;
  header.NumberOfLevels = 1;
  header.NumberOfStores = 2;
  header.Arrays = { { arrayName, ValueType::UInt8 } };
  header.Overviews = { { 5, 1 } };
  for (const double time : { 0.5, 1.5 })
  {
    TimeStepDescription& step = header.TimeSteps.emplace_back();
    step.Time = time;
    step.Folder = "000001";
    step.Ranges = { {} };
    step.Stores = { { 4, 1ULL << 61, 0xFEDCBA9876543210u }, { 0, 0, 7 } };
    step.Overviews = { { { 2, 4096, 8 } } };
  }
  header.TimeSteps[0].Stores[1].Seals = { 0x0123456789ABCDEFu, 5 };
  return header;
}

/// The same document without line breaks: nothing is cut out of it.
std::string WriteInOneLine(const std::string& text)
{
  Json document = Json::parse(text);
  document.erase("checksum");
  std::string line = document.dump();
  line.back() = ',';
  return line + "\"checksum\":\"" + FormatChecksum(ComputeChecksum(line.data(), line.size())) +
    "\"}";
}

std::string Replace(std::string text, const std::string& from, const std::string& to)
{
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

} // namespace

TEST(StoreLists, AreCutOutOfAHeader)
{
  const auto cut = CutStoreLists(MakeHeaderOfLists("a").Format());
  ASSERT_TRUE(cut.has_value());
  // Of each time step first those of its overviews: members are sorted.
  ASSERT_EQ(cut->Lists.size(), 4u);
  EXPECT_EQ(cut->Lists[2][0].Checksum, 8u);
  const std::vector<StoreDescription>& stores = cut->Lists[1];
  ASSERT_EQ(stores.size(), 2u);
  EXPECT_EQ(stores[0].Blocks, 4u);
  EXPECT_EQ(stores[0].Bytes, 1ULL << 61);
  EXPECT_EQ(stores[0].Checksum, 0xFEDCBA9876543210u);
  EXPECT_TRUE(stores[0].Seals.empty());
  EXPECT_EQ(stores[1].Seals, (std::vector<std::uint64_t>{ 0x0123456789ABCDEFu, 5 }));
  const Json rest = Json::parse(cut->Rest);
  EXPECT_EQ(rest["stores"], 2);
  EXPECT_EQ(rest["timeSteps"][1]["stores"], Json::array({ 3 }));
}

TEST(StoreLists, GiveTheHeaderThatTheWholeDocumentGives)
{
  // A name with quotes or backslashes might hide the name of a list, and one might look like it.
  for (const char* const name : { "a", "stores", "\"stores\": [", "\\" })
  {
    const std::string text = MakeHeaderOfLists(name).Format();
    EXPECT_EQ(CutStoreLists(text).has_value(), name == std::string("a")) << name;
    const std::string line = WriteInOneLine(text);
    EXPECT_FALSE(CutStoreLists(line).has_value());
    EXPECT_EQ(Require(BlockedVolumeHeader::Parse(text, Path)).Format(), text);
    EXPECT_EQ(Require(BlockedVolumeHeader::Parse(line, Path)).Format(), text);
  }
}

TEST(StoreLists, OfAnotherFormAreLeftToTheDocument)
{
  const std::string text = MakeHeaderOfLists("a").Format();
  const std::pair<const char*, const char*> changes[] = { { "\"blocks\": 4", "\"blocks\": 04" },
    { "\"blocks\": 4", "\"blocks\": 4.0" }, { "\"blocks\": 4", "\"blocks\": -4" },
    { "\"blocks\": 4", "\"blocks\": " }, { "\"blocks\": 4", "\"blocks\": 18446744073709551616" },
    { "\"blocks\": 4", "\"blocks\": 4, \"host\": 0" }, { "fedcba98", "FEDCBA98" },
    { "fedcba98", "fedcba9" }, { "0123456789abcdef", "0123456789abcde" },
    { "\"stores\": [", "\"stores\" : [" }, { "\"stores\": [", "\"stores\": null, \"x\": [" },
    { "\"format\": \"", "\"format\": \"\\u0020" } };
  for (const auto& change : changes)
  {
    EXPECT_FALSE(CutStoreLists(Replace(text, change.first, change.second)).has_value())
      << change.second;
  }
  for (std::size_t size = text.find("\"stores\": ["); size < text.rfind(']'); ++size)
  {
    EXPECT_FALSE(BlockedVolumeHeader::Parse(text.substr(0, size), Path).IsOk());
  }
}
