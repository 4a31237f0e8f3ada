// SPDX-License-Identifier: BSD-3-Clause
// Many ways to do the same: any number of ranks and threads, any memory, any cache.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/VolumeOnDisk.h"

#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Ranks/Query/LevelExtraction.h"
#include "Storage/Store/StoredBlockSource.h"

#include <algorithm>
#include <random>

using namespace isosurface;

namespace
{

constexpr double RepeatedIsovalue = 30;
const std::string SurfacePath = "/data/surface.eix";

// How a run does its work, drawn at random.
struct Way
{
  int Ranks = 1;
  int Threads = 1;
  std::uint64_t WriterMemory = 0;
  std::uint64_t CacheBytes = 0;
  std::uint64_t RecordMemory = 0;
  std::size_t LayoutNumber = 0;
};

Way DrawWay(std::mt19937& random)
{
  const auto draw = [&random](std::uint64_t low, std::uint64_t high)
  { return std::uniform_int_distribution<std::uint64_t>(low, high)(random); };
  Way way;
  way.Ranks = static_cast<int>(draw(1, 7));
  way.Threads = static_cast<int>(draw(1, 5));
  way.WriterMemory = draw(6, 40) * 1000000;
  way.CacheBytes = draw(0, 1) * draw(1000, 2000000);
  way.RecordMemory = draw(200, 100000);
  way.LayoutNumber = draw(0, 3);
  return way;
}

std::ostream& operator<<(std::ostream& out, const Way& way)
{
  return out << way.Ranks << " ranks, " << way.Threads << " threads, writer's memory "
             << way.WriterMemory << ", cache " << way.CacheBytes << ", memory of records "
             << way.RecordMemory << ", layout " << way.LayoutNumber;
}

SurfaceQuery MakeQuery(const Communicator& ranks)
{
  return { { 0, 0, { RepeatedIsovalue } }, ranks.GetRank(), ranks.GetSize() };
}

void WriteEdgeIndexFile(
  Communicator& ranks, FileSystem& disk, BlockedVolume& volume, const Way& way)
{
  const SurfaceQuery query = MakeQuery(ranks);
  QueryStatistics statistics;
  auto active = Require(
    FindActiveBlocks(volume, { { 0, 0, query.Isovalues }, query.Rank, query.Ranks }, statistics));
  std::sort(active.begin(), active.end(),
    [](const BlockReference& a, const BlockReference& b) { return a.Block < b.Block; });
  std::vector<std::int64_t> numbers;
  for (const BlockReference& reference : active)
  {
    numbers.push_back(reference.Block);
  }
  StoredBlockSource source(volume, 0, 0, 0, std::move(active));
  EdgeIndexHeader header;
  header.Geometry = volume.GetHeader().Grid;
  header.Type = ValueType::Int16;
  header.Isovalues = query.Isovalues;
  const auto written = EdgeIndexWriteJob(
    ranks, disk, SurfacePath, header, source, numbers, { way.Threads, way.RecordMemory })
                         .Run();
  EXPECT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
}

PlainSurface DropNormals(PlainSurface surface)
{
  for (auto& point : surface.Points)
  {
    std::fill(point.second.begin() + 3, point.second.end(), 0);
  }
  return surface;
}

// Writes the volume and the edge-index file of its surface, and extracts the surface.
PlainSurface DoAll(MemoryDisk& disk, const SampleVolume<std::int16_t>& samples, const Way& way)
{
  const Layout layouts[] = { SlabOfEach, WholeOnAll, OverlappingColumns, WholeOnLast };
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.Threads = way.Threads;
  settings.MemoryLimit = way.WriterMemory;
  WriteVolumeOk(disk, samples, settings, way.Ranks, layouts[way.LayoutNumber]);
  return UniteRanks(ThreadCommunicator::Collect(way.Ranks,
    [&](Communicator& ranks)
    {
      const auto volume = OpenVolume(disk, way.CacheBytes);
      const SurfaceQuery query = MakeQuery(ranks);
      const ContourRequest request = MakePlainRequest(query.Isovalues);
      ExtractionOutcome outcome;
      const Status status = ExtractLevel({ volume, query, request, way.Threads, {} }, 0, outcome);
      EXPECT_TRUE(status.IsOk()) << status.GetMessage();
      WriteEdgeIndexFile(ranks, disk, *volume, way);
      return MakePlain(outcome.Extracted);
    }));
}

} // namespace

TEST(Determinism, ManyWaysGiveTheSameBytesAndTheSameSurface)
{
  const auto samples = MakeVolume<std::int16_t>({ 60, 44, 38 });
  SampleVolume<std::int16_t> placed = samples;
  placed.Geometry = MakeGeometry(samples.GetDimensions());
  const PlainSurface expected = UniteRanks({ ContourPlainly(placed, { RepeatedIsovalue }) });
  ASSERT_GT(expected.Triangles.size(), 1000u);
  MemoryDisk first;
  // The oracle takes the normals of a grid of unit spacing.
  const PlainSurface one = DoAll(first, samples, { 1, 1, 1000000000, 0, 100000, 0 });
  EXPECT_TRUE(DropNormals(one) == DropNormals(expected));
  std::mt19937 random(20261122);
  const int runs = LongTests ? 100 : 15;
  for (int run = 0; run < runs && !testing::Test::HasFailure(); ++run)
  {
    const Way way = DrawWay(random);
    MemoryDisk disk;
    EXPECT_TRUE(DoAll(disk, samples, way) == one) << way;
    EXPECT_TRUE(disk.Copy() == first.Copy()) << way;
  }
}
