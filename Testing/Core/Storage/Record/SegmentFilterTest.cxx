// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/SegmentFilter.h"

#include "Fixtures/SampleVolume.h"
#include "Storage/Record/OrderedSample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

template <typename T>
class FilterOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(FilterOfType, AllValueTypes, );

template <typename T>
T FromBits(std::uint64_t bits)
{
  T value;
  std::memcpy(&value, &bits, sizeof(T));
  return value;
}

/// The definition, with wide arithmetic: the code of a sample that follows its prediction.
template <typename T>
std::uint64_t Encode(std::uint64_t ordered, std::uint64_t predicted)
{
  const int bits = 8 * static_cast<int>(sizeof(T));
  const std::uint64_t mask = bits == 64 ? ~std::uint64_t{ 0 } : (std::uint64_t{ 1 } << bits) - 1;
  const std::uint64_t residual = (ordered - predicted) & mask;
  const bool isNegative = (residual >> (bits - 1)) != 0;
  return (isNegative ? 2 * ((~residual + 1) & mask) - 1 : 2 * residual) & mask;
}

/// Byte planes, from their definition.
std::vector<std::uint8_t> Arrange(const std::vector<std::uint64_t>& codes, std::size_t size)
{
  std::vector<std::uint8_t> bytes;
  for (std::size_t byte = 0; byte < size; ++byte)
  {
    for (const std::uint64_t code : codes)
    {
      bytes.push_back(static_cast<std::uint8_t>(code >> (8 * byte)));
    }
  }
  return bytes;
}

} // namespace

TYPED_TEST(FilterOfType, OrderedSamplesKeepOrderAndBits)
{
  using T = TypeParam;
  using U = OrderedOf<T>;
  std::mt19937_64 random(1);
  std::vector<T> values = { std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max(), T(0),
    T(1), static_cast<T>(-1) };
  for (int index = 0; index < 1000; ++index)
  {
    values.push_back(FromBits<T>(random()));
  }
  for (std::size_t index = 0; index < values.size(); ++index)
  {
    U a;
    U b;
    std::memcpy(&a, &values[index], sizeof(T));
    std::memcpy(&b, &values[values.size() - 1 - index], sizeof(T));
    EXPECT_EQ(OrderedSample<T>::ToBits(OrderedSample<T>::FromBits(a)), a);
    if (values[index] < values[values.size() - 1 - index])
    {
      EXPECT_LT(OrderedSample<T>::FromBits(a), OrderedSample<T>::FromBits(b));
    }
  }
}

TYPED_TEST(FilterOfType, WritesTheBytesOfTheSpecificationAndRestoresTheSamples)
{
  using T = TypeParam;
  using U = OrderedOf<T>;
  std::mt19937_64 random(2);
  for (const std::size_t count : { 0u, 1u, 7u, 8u, 9u, 63u, 1023u, 1024u, 1025u, 3001u })
  {
    // Any bits at all, NaN of every payload among them, at an odd address.
    std::vector<std::uint8_t> memory(count * sizeof(T) + 1);
    std::vector<U> predictions(count);
    std::generate(
      memory.begin(), memory.end(), [&] { return static_cast<std::uint8_t>(random()); });
    std::generate(predictions.begin(), predictions.end(), [&] { return static_cast<U>(random()); });
    const std::uint8_t* samples = memory.data() + 1;
    for (const SamplePredictor predictor :
      { SamplePredictor::None, SamplePredictor::Previous, SamplePredictor::Coarser })
    {
      std::vector<std::uint64_t> codes;
      std::uint64_t previous = std::uint64_t{ 1 } << (8 * sizeof(T) - 1);
      for (std::size_t index = 0; index < count; ++index)
      {
        U bits;
        std::memcpy(&bits, samples + index * sizeof(T), sizeof(T));
        const std::uint64_t ordered = OrderedSample<T>::FromBits(bits);
        codes.push_back(predictor == SamplePredictor::None ? bits
            : predictor == SamplePredictor::Previous       ? Encode<T>(ordered, previous)
                                                     : Encode<T>(ordered, predictions[index]));
        previous = ordered;
      }
      const std::vector<std::uint8_t> expected = Arrange(codes, sizeof(T));
      std::vector<std::uint8_t> filtered(count * sizeof(T));
      ApplyFilter(
        predictor, ValueTypeOf<T>::Value, samples, count, predictions.data(), filtered.data());
      ASSERT_EQ(filtered, expected) << static_cast<int>(predictor) << ", " << count << " samples";
      std::vector<std::uint8_t> back(count * sizeof(T));
      RevertFilter(
        predictor, ValueTypeOf<T>::Value, filtered.data(), count, predictions.data(), back.data());
      ASSERT_TRUE(std::equal(back.begin(), back.end(), samples))
        << static_cast<int>(predictor) << ", " << count << " samples";
    }
  }
}

TEST(SamplePredictor, HasTheNumbersOfTheSpecification)
{
  for (int number = 0; number < 256; ++number)
  {
    EXPECT_EQ(IsPredictor(static_cast<std::uint8_t>(number)), number < 3) << number;
  }
}
