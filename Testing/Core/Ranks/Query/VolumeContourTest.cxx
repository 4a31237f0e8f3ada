// SPDX-License-Identifier: BSD-3-Clause
// Surfaces within a budget of time, on ranks that have learned different things.
#include "Ranks/Query/VolumeContour.h"
#include "Fixtures/VolumeOnDisk.h"

using namespace isosurface;

namespace
{

/// A volume whose isosurface passes through one block alone.
SampleVolume<std::uint8_t> MakeDot(const Index3& size)
{
  return SampleVolume<std::uint8_t>(size,
    [](auto i, auto j, auto k)
    { return static_cast<std::uint8_t>(i == 5 && j == 5 && k == 5 ? 200 : 0); });
}

} // namespace

// A rank without active blocks measures nothing: it would choose a level by a coarse extraction
// first, while the others go on to the next collective.
TEST(VolumeContour, RanksWithoutActiveBlocksGoTheWayOfTheOthers)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeDot({ 60, 50, 40 }), MakeSettings(16, 1), 1);
  constexpr int ranks = 3;
  std::vector<std::vector<std::uint64_t>> triangles(ranks);
  std::vector<std::vector<int>> levels(ranks);
  ThreadCommunicator::Run(ranks,
    [&](Communicator& communicator)
    {
      const auto rank = static_cast<std::size_t>(communicator.GetRank());
      const auto volume = OpenVolume(disk);
      SurfaceQuery query{ { 0, 0, { 100 } }, communicator.GetRank(), ranks };
      ContourRequest request;
      request.Isovalues = query.Isovalues;
      VolumeContour contour;
      for (int time = 0; time < 4; ++time)
      {
        ExtractionOutcome outcome;
        const Status status = contour.ExtractWithinBudget(
          communicator, { 1000, 0 }, { volume, query, request, 1, {} }, 0, outcome);
        EXPECT_TRUE(status.IsOk()) << status.GetMessage();
        triangles[rank].push_back(outcome.Extracted.NumberOfTriangles);
        levels[rank].push_back(outcome.Cost.Level);
      }
    });
  for (std::size_t time = 0; time < 4; ++time)
  {
    std::uint64_t sum = 0;
    for (std::size_t rank = 0; rank < ranks; ++rank)
    {
      sum += triangles[rank].at(time);
      EXPECT_EQ(levels[rank].at(time), 0);
    }
    EXPECT_EQ(sum, 8u) << "an octahedron around the one vertex that is inside";
  }
}
