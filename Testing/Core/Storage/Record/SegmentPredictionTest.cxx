// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/SegmentPrediction.h"

#include "Fixtures/SampleVolume.h"
#include "Storage/Record/OrderedSample.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

template <typename T>
class PredictionOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(PredictionOfType, AllValueTypes, );

template <typename U>
U Mean(U a, U b)
{
  // Half of the sum, rounded up, without a wider type.
  return static_cast<U>(a / 2 + b / 2 + ((a | b) & 1));
}

/// The coarser level's samples at and around a vertex, straight from the definition.
template <typename T>
OrderedOf<T> Predict(const SampleView& coarser, const Index3& vertex)
{
  using U = OrderedOf<T>;
  const auto at = [&](int x, int y, int z)
  {
    const int up[3] = { x, y, z };
    Index3 near{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      near[axis] = std::min((vertex[axis] + up[axis]) >> 1, coarser.Available.High[axis] - 1);
    }
    U bits;
    std::memcpy(&bits, coarser.At<T>(near), sizeof(U));
    return OrderedSample<T>::FromBits(bits);
  };
  const auto column = [&](int x)
  { return Mean<U>(Mean<U>(at(x, 0, 0), at(x, 1, 0)), Mean<U>(at(x, 0, 1), at(x, 1, 1))); };
  return Mean<U>(column(0), column(1));
}

} // namespace

TYPED_TEST(PredictionOfType, IsTheMeanOfTheCoarserVerticesAround)
{
  using T = TypeParam;
  std::mt19937_64 random(3);
  SegmentPrediction prediction;
  for (const Index3& size :
    { Index3{ 40, 33, 18 }, Index3{ 17, 2, 35 }, Index3{ 1, 1, 1 }, Index3{ 50, 66, 34 } })
  {
    const BlockGrid grid(size, 32);
    for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
    {
      for (int level = 0; level + 1 < grid.GetNumberOfLevels(); ++level)
      {
        SampleView coarser;
        coarser.Type = ValueTypeOf<T>::Value;
        coarser.Box = grid.GetVertices(block, level + 1);
        coarser.Available = grid.GetGhostedVertices(block, level + 1);
        const Index3 extent = coarser.Available.GetSize();
        coarser.Stride = { 1, extent[0], extent[0] * extent[1] };
        std::vector<T> samples(static_cast<std::size_t>(coarser.Available.GetNumberOfVertices()));
        for (T& sample : samples)
        {
          const std::uint64_t bits = random();
          std::memcpy(&sample, &bits, sizeof(T));
        }
        coarser.First = samples.data();
        const BlockSegment segment(grid, block, level);
        const auto* predicted =
          static_cast<const OrderedOf<T>*>(prediction.Compute(segment, coarser));
        std::size_t wrong = 0;
        segment.VisitRows(segment.GetBox(),
          [&](const SegmentRow& row)
          {
            for (std::int64_t n = 0; n < row.Count; ++n)
            {
              wrong += predicted[row.Offset + static_cast<std::uint64_t>(n)] !=
                Predict<T>(coarser, { row.I + n * row.Step, row.J, row.K });
            }
          });
        ASSERT_EQ(wrong, 0u) << "block " << block << ", level " << level;
      }
    }
  }
}
