// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/PlainContour.h"
#include "Surface/Contour/GridBlockSource.h"

#include <gtest/gtest.h>

#include <random>

using namespace isosurface;

namespace
{

template <typename T>
KeyRange FindRangePlainly(const SampleVolume<T>& volume, const VertexBox& box)
{
  KeyRange range;
  VisitVertices(box,
    [&](const Index3& vertex)
    {
      const ValueKey key = MakeValueKey(volume.At(vertex));
      range.Minimum = std::min(range.Minimum, key);
      range.Maximum = std::max(range.Maximum, key);
    });
  return range;
}

template <typename T>
class BlockRangesOfType : public testing::Test
{
};
TYPED_TEST_SUITE(BlockRangesOfType, AllValueTypes);

} // namespace

TYPED_TEST(BlockRangesOfType, EqualBruteForce)
{
  std::mt19937 random(70);
  const Index3 sizes[] = { { 1, 1, 1 }, { 33, 34, 2 }, { 65, 40, 33 }, { 70, 1, 9 },
    { 31, 5, 66 } };
  for (const Index3& dimensions : sizes)
  {
    auto volume = MakeRandomVolume<TypeParam>(random, dimensions, 120);
    volume.Samples[random() % volume.Samples.size()] = std::numeric_limits<TypeParam>::max();
    volume.Samples[random() % volume.Samples.size()] = std::numeric_limits<TypeParam>::lowest();
    const auto ranges = Require(BlockRanges::Compute(volume.GetView(), 2));
    for (std::int64_t block = 0; block < ranges.GetGrid().GetNumberOfBlocks(); ++block)
    {
      const KeyRange expected = FindRangePlainly(volume, ranges.GetGrid().GetVertices(block));
      EXPECT_EQ(ranges.GetRange(block).Minimum, expected.Minimum);
      EXPECT_EQ(ranges.GetRange(block).Maximum, expected.Maximum);
    }
  }
}

TEST(BlockRanges, ABlockOfNaNOnlyIsNeverActive)
{
  SampleVolume<float> volume({ 3, 3, 3 });
  for (float& sample : volume.Samples)
  {
    sample = std::numeric_limits<float>::quiet_NaN();
  }
  const auto ranges = Require(BlockRanges::Compute(volume.GetView(), 1));
  EXPECT_TRUE(ranges.FindActiveBlocks({ 0.0, -1e300, 1e300 }).empty());
  volume.Samples[13] = 5;
  const Result<BlockRanges> withNumber = BlockRanges::Compute(volume.GetView(), 1);
  EXPECT_EQ(withNumber->FindActiveBlocks({ 5.0 }).size(), 1u);
  EXPECT_TRUE(withNumber->FindActiveBlocks({ 5.5 }).empty());
}

TEST(GridBlockSource, TheActiveBlocksGiveTheWholeSurface)
{
  // A ball in a corner of the volume, so that most blocks are left out.
  const SampleVolume<std::int32_t> volume({ 100, 70, 80 },
    [](auto i, auto j, auto k)
    { return 1000 - (i - 30) * (i - 30) - (j - 31) * (j - 31) - k * k; });
  const auto ranges = Require(BlockRanges::Compute(volume.GetView(), 2));
  const ContourRequest request = MakePlainRequest({ 900.0, 200.0 });
  GridBlockSource source(volume.GetView(), ranges, request.Isovalues);
  EXPECT_LT(source.GetNumberOfBlocks(), 9u);
  const auto surface = Require(ExtractSurface(volume.Geometry, source, request, 2));
  EXPECT_EQ(surface.NumberOfBlocks, source.GetNumberOfBlocks());
  EXPECT_TRUE(MakePlain(surface) == ContourPlainly(volume, request.Isovalues));
}

TEST(GridBlockSource, PiecesWithGhostsEqualTheWhole)
{
  // Two ranks have halves that share a plane of vertices, and a ghost layer.
  std::mt19937 random(71);
  const auto volume = MakeRandomVolume<float>(random, { 50, 20, 20 }, 100);
  const ContourRequest request = MakePlainRequest({ 10.25 });
  std::vector<PlainSurface> ranks;
  for (const bool second : { false, true })
  {
    SampleView piece = volume.GetView();
    piece.Available.Low[0] = second ? 20 : 0;
    piece.Available.High[0] = second ? 50 : 23;
    piece.First = static_cast<const float*>(piece.First) + piece.Available.Low[0];
    piece.Box = piece.Available;
    piece.Box.Low[0] = second ? 21 : 0;
    piece.Box.High[0] = second ? 50 : 22;
    const Result<BlockRanges> ranges = BlockRanges::Compute(piece, 1);
    GridBlockSource source(piece, *ranges, request.Isovalues);
    const auto surface = Require(ExtractSurface(volume.Geometry, source, request, 1));
    ranks.push_back(MakePlain(surface));
  }
  EXPECT_TRUE(UniteRanks(ranks) == ContourPlainly(volume, request.Isovalues));
}
