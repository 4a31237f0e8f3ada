// SPDX-License-Identifier: BSD-3-Clause
// Headers of volumes on rectilinear grids.
#include "Storage/Store/BlockedVolumeHeader.h"

#include "Fixtures/Require.h"
#include "Storage/Store/JsonDocument.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <functional>

using namespace isosurface;

namespace
{

const std::string RectilinearPath = "/data/a.bvol";

/// Of 50 x 10 x 1 vertices.
BlockedVolumeHeader MakeLinedHeader()
{
  BlockedVolumeHeader header;
  header.Grid.Extent = { -5, 44, 0, 9, 7, 7 };
  header.BlockSize = 16;
  header.Arrays = { { "a", ValueType::Float32 } };
  TimeStepDescription step;
  step.Folder = "000001";
  step.Ranges = { { MakeValueKey(-2.5f), MakeValueKey(1.5f) } };
  step.Stores = { { 4, 16384, 7 } };
  header.TimeSteps = { step };
  header.Lines.emplace();
  for (int n = 0; n < 50; ++n)
  {
    header.Lines->Coordinates[0].push_back(0.1 * n * n - 1.0 / 3.0);
  }
  for (int n = 0; n < 10; ++n)
  {
    header.Lines->Coordinates[1].push_back(-5e-324 + 1e-300 * n);
  }
  header.Lines->Coordinates[2].push_back(1e300);
  header.FrameGrid();
  return header;
}

void ExpectRefused(const Json& document, const char* part)
{
  const auto header = BlockedVolumeHeader::Parse(FormatDocument(document), RectilinearPath);
  ASSERT_FALSE(header.IsOk()) << part;
  EXPECT_EQ(header.GetStatus().GetCode(), StatusCode::Corrupt);
  EXPECT_EQ(header.GetStatus().GetMessage().find(RectilinearPath), 0u)
    << header.GetStatus().GetMessage();
  EXPECT_NE(header.GetStatus().GetMessage().find(part), std::string::npos)
    << header.GetStatus().GetMessage() << " does not say " << part;
}

} // namespace

TEST(RectilinearHeader, KeepsTheCoordinatesOfARectilinearGridExactly)
{
  const BlockedVolumeHeader header = MakeLinedHeader();
  const auto parsed = Require(BlockedVolumeHeader::Parse(header.Format(), RectilinearPath));
  ASSERT_TRUE(parsed.Lines);
  EXPECT_EQ(parsed.Lines->Coordinates, header.Lines->Coordinates);
  EXPECT_EQ(parsed.Format(), header.Format());
  BlockedVolumeHeader regular = header;
  regular.Lines.reset();
  EXPECT_EQ(regular.Format().find("coordinates"), std::string::npos);
}

TEST(RectilinearHeader, OverviewHasTheCoordinatesOfItsVertices)
{
  BlockedVolumeHeader header = MakeLinedHeader();
  header.NumberOfLevels = 2;
  header.Overviews = { { 5, 1 } };
  for (TimeStepDescription& step : header.TimeSteps)
  {
    step.Overviews = { { { 1, 4096, 7 } } };
  }
  const BlockedVolumeHeader overview = header.MakeOverview(0);
  const Index3 dimensions = overview.Grid.GetDimensions();
  ASSERT_TRUE(overview.Lines->Check(dimensions).IsOk());
  for (std::size_t n = 0; n < overview.Lines->Coordinates[0].size(); ++n)
  {
    EXPECT_EQ(overview.Lines->Coordinates[0][n], header.Lines->Coordinates[0][4 * n]);
  }
}

TEST(RectilinearHeader, RefusesCoordinatesThatAreNone)
{
  const std::pair<const char*, std::function<void(Json&)>> changes[] = {
    { "do not ascend on axis x", [](Json& c) { c[0][7] = c[0][6]; } },
    { "do not ascend on axis y", [](Json& c) { c[1][9] = -1; } },
    { "49 coordinates on axis x for 50", [](Json& c) { c[0].erase(c[0].begin()); } },
    { "2 coordinates on axis z for 1", [](Json& c) { c[2].push_back(2e300); } },
    { "not three arrays of numbers", [](Json& c) { c[2][0] = nullptr; } },
    { "not three arrays of numbers", [](Json& c) { c[1] = "0"; } },
    { "is not an array of 3", [](Json& c) { c.erase(2); } },
    { "is not an array of 3", [](Json& c) { c = nullptr; } },
  };
  for (const auto& change : changes)
  {
    SCOPED_TRACE(change.first);
    Json document = Json::parse(MakeLinedHeader().Format());
    change.second(document["grid"]["coordinates"]);
    ExpectRefused(document, change.first);
  }
  Json turned = Json::parse(MakeLinedHeader().Format());
  turned["grid"]["direction"] = { 0, 1, 0, 1, 0, 0, 0, 0, 1 };
  ExpectRefused(turned, "the grid is rectilinear, and has a direction");
}
