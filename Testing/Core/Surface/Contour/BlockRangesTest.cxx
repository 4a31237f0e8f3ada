// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/PlainContour.h"
#include "Surface/Contour/GridBlockSource.h"

#include <gtest/gtest.h>

#include <random>

namespace isosurface
{
namespace
{

template <typename T>
KeyRange FindRangePlainly(const SampleVolume<T>& volume, const VertexBox& box)
{
  KeyRange range;
  for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
    {
      for (std::int64_t i = box.Low[0]; i < box.High[0]; ++i)
      {
        const ValueKey key = MakeValueKey(volume.At(i, j, k));
        range.Minimum = std::min(range.Minimum, key);
        range.Maximum = std::max(range.Maximum, key);
      }
    }
  }
  return range;
}

template <typename T>
class BlockRangesOfType : public testing::Test
{
};
using AllTypes = testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
  std::int32_t, std::uint32_t, std::int64_t, std::uint64_t, float, double>;
TYPED_TEST_SUITE(BlockRangesOfType, AllTypes);

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
    const Result<BlockRanges> ranges = BlockRanges::Compute(volume.GetView(), 2);
    ASSERT_TRUE(ranges.IsOk());
    for (std::int64_t block = 0; block < ranges->GetGrid().GetNumberOfBlocks(); ++block)
    {
      const KeyRange expected = FindRangePlainly(volume, ranges->GetGrid().GetVertices(block));
      EXPECT_EQ(ranges->GetRange(block).Minimum, expected.Minimum);
      EXPECT_EQ(ranges->GetRange(block).Maximum, expected.Maximum);
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
  const Result<BlockRanges> ranges = BlockRanges::Compute(volume.GetView(), 1);
  ASSERT_TRUE(ranges.IsOk());
  EXPECT_TRUE(ranges->FindActiveBlocks({ 0.0, -1e300, 1e300 }).empty());
  volume.Samples[13] = 5;
  const Result<BlockRanges> withNumber = BlockRanges::Compute(volume.GetView(), 1);
  EXPECT_EQ(withNumber->FindActiveBlocks({ 5.0 }).size(), 1u);
  EXPECT_TRUE(withNumber->FindActiveBlocks({ 5.5 }).empty());
}

TEST(GridBlockSource, TheActiveBlocksGiveTheWholeSurface)
{
  // A ball in a corner of the volume, so that most blocks are left out.
  SampleVolume<std::int32_t> volume({ 100, 70, 80 });
  for (std::int64_t k = 0; k < 80; ++k)
  {
    for (std::int64_t j = 0; j < 70; ++j)
    {
      for (std::int64_t i = 0; i < 100; ++i)
      {
        volume.At(i, j, k) =
          static_cast<std::int32_t>(1000 - (i - 30) * (i - 30) - (j - 31) * (j - 31) - k * k);
      }
    }
  }
  const Result<BlockRanges> ranges = BlockRanges::Compute(volume.GetView(), 2);
  ASSERT_TRUE(ranges.IsOk());
  ContourRequest request;
  request.Isovalues = { 900.0, 200.0 };
  request.Normals = true;
  request.GlobalIds = true;
  GridBlockSource source(volume.GetView(), *ranges, request.Isovalues);
  EXPECT_LT(source.GetNumberOfBlocks(), 9u);
  const Result<Surface> surface = ExtractSurface(volume.Geometry, source, request, 2);
  ASSERT_TRUE(surface.IsOk()) << surface.GetStatus().GetMessage();
  EXPECT_EQ(surface->NumberOfBlocks, source.GetNumberOfBlocks());
  EXPECT_TRUE(MakePlain(*surface) == ContourPlainly(volume, request.Isovalues));
}

TEST(GridBlockSource, PiecesWithGhostsEqualTheWhole)
{
  // Two ranks have halves that share a plane of vertices, and a ghost layer.
  std::mt19937 random(71);
  const auto volume = MakeRandomVolume<float>(random, { 50, 20, 20 }, 100);
  ContourRequest request;
  request.Isovalues = { 10.25 };
  request.Normals = true;
  request.GlobalIds = true;
  PlainSurface merged;
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
    const Result<Surface> surface = ExtractSurface(volume.Geometry, source, request, 1);
    ASSERT_TRUE(surface.IsOk()) << surface.GetStatus().GetMessage();
    const PlainSurface plain = MakePlain(*surface);
    merged.Triangles.insert(merged.Triangles.end(), plain.Triangles.begin(), plain.Triangles.end());
    for (const auto& [id, bits] : plain.Points)
    {
      EXPECT_EQ(merged.Points.emplace(id, bits).first->second, bits);
    }
  }
  std::sort(merged.Triangles.begin(), merged.Triangles.end());
  EXPECT_TRUE(merged == ContourPlainly(volume, request.Isovalues));
}

} // namespace isosurface
