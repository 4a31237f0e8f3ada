// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/TupleRanges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

template <typename T>
std::vector<T> MakeValues(std::size_t count)
{
  std::mt19937 random(7);
  std::vector<T> values(count);
  for (T& value : values)
  {
    value = static_cast<T>(static_cast<int>(random() % 2000001) - 1000000);
  }
  return values;
}

template <typename T>
void ExpectRangesOf(std::size_t tuples, std::size_t components)
{
  const std::vector<T> values = MakeValues<T>(tuples * components);
  for (const int threads : { 1, 3 })
  {
    const TupleRanges<T> ranges = FindTupleRanges(values.data(), tuples, components, threads);
    ASSERT_EQ(ranges.Components.size(), components);
    EXPECT_TRUE(ranges.AreFinite);
    std::vector<double> norms(tuples, 0);
    for (std::size_t component = 0; component < components; ++component)
    {
      std::vector<T> column;
      for (std::size_t tuple = 0; tuple < tuples; ++tuple)
      {
        column.push_back(values[tuple * components + component]);
        norms[tuple] += static_cast<double>(column.back()) * static_cast<double>(column.back());
      }
      const auto [minimum, maximum] = std::minmax_element(column.begin(), column.end());
      EXPECT_EQ(ranges.Components[component].Minimum, *minimum);
      EXPECT_EQ(ranges.Components[component].Maximum, *maximum);
    }
    if (components > 1)
    {
      EXPECT_EQ(ranges.SquaredNorm.Minimum, *std::min_element(norms.begin(), norms.end()));
      EXPECT_EQ(ranges.SquaredNorm.Maximum, *std::max_element(norms.begin(), norms.end()));
    }
  }
}

} // namespace

TEST(TupleRanges, AreThoseOfEachColumnAndOfTheNorms)
{
  for (const std::size_t tuples : { 1, 15, 16, 17, 65536, 65537, 200003 })
  {
    ExpectRangesOf<float>(tuples, 3);
    ExpectRangesOf<float>(tuples, 2);
    ExpectRangesOf<double>(tuples, 4);
    ExpectRangesOf<double>(tuples, 1);
    ExpectRangesOf<long long>(tuples, 1);
  }
}

TEST(TupleRanges, OfNoTuplesAreEmpty)
{
  const TupleRanges<float> ranges = FindTupleRanges<float>(nullptr, 0, 2, 1);
  EXPECT_GT(ranges.Components[0].Minimum, ranges.Components[0].Maximum);
}

TEST(TupleRanges, ValuesThatAreNotFiniteAreTold)
{
  for (const float value :
    { std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity() })
  {
    std::vector<float> values = MakeValues<float>(100000);
    values[99998] = value;
    EXPECT_FALSE(FindTupleRanges(values.data(), values.size(), 1, 2).AreFinite);
    EXPECT_FALSE(FindTupleRanges(values.data(), values.size() / 4, 4, 2).AreFinite);
  }
}
