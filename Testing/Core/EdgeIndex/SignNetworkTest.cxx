// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/SignNetwork.h"
#include "EdgeIndex/NetworkSigns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

/// The network bit by bit, as Documentation/formats/edge-index.md has it.
int PredictPlainly(const SignNetworkWeights& weights, const SignNetworkRow& row,
  const SignNetworkInputs& inputs, std::vector<std::int64_t>& hidden)
{
  std::vector<bool> bits;
  for (std::size_t n = 0; n < inputs.Patterns.size(); ++n)
  {
    for (int bit = 0; bit < SignNetworkInputs::Bits[n]; ++bit)
    {
      bits.push_back((inputs.Patterns[n] >> bit & 1) != 0);
    }
  }
  bits.insert(bits.end(), row.begin(), row.end());
  bits.push_back(true);
  EXPECT_EQ(bits.size(), weights.First.size());
  std::vector<std::int64_t> first;
  for (std::size_t i = 0; i < SignNetworkWeights::Width; ++i)
  {
    std::int64_t sum = 0;
    for (std::size_t n = 0; n < bits.size(); ++n)
    {
      sum += bits[n] ? weights.First[n][i] : 0;
    }
    first.push_back(std::clamp<std::int64_t>(sum, 0, 2047));
  }
  std::int64_t third = weights.ThirdAdded;
  hidden.clear();
  for (std::size_t n = 0; n < SignNetworkWeights::Depth; ++n)
  {
    std::int64_t sum = weights.SecondAdded[n];
    for (std::size_t i = 0; i < first.size(); ++i)
    {
      sum += first[i] * weights.Second[n][i];
    }
    hidden.push_back(std::clamp<std::int64_t>(sum >> 10, 0, 2047));
    third += hidden.back() * weights.Third[n];
  }
  return static_cast<int>(std::clamp<std::int64_t>(third >> 10, -2047, 2047));
}

} // namespace

TEST(SignNetwork, LooksUpWhatItsWeightsAddUpTo)
{
  std::mt19937 random(3);
  const SignNetwork& network = GetSignNetwork();
  int least = 2047;
  int most = -2047;
  for (int round = 0; round < 2000; ++round)
  {
    SignNetworkRow row;
    SignNetworkInputs inputs;
    std::generate(row.begin(), row.end(), [&] { return random() % 4 == 0; });
    for (std::size_t n = 0; n < inputs.Patterns.size(); ++n)
    {
      const unsigned pattern = random() & random();
      inputs.Patterns[n] =
        static_cast<std::uint8_t>(pattern & ((1u << SignNetworkInputs::Bits[n]) - 1));
    }
    std::vector<std::int64_t> expected;
    const int plain = PredictPlainly(LearntSignNetwork, row, inputs, expected);
    std::array<std::int16_t, SignNetwork::Depth> hidden{};
    EXPECT_EQ(network.Predict(network.MakeRow(row), inputs, hidden), plain);
    EXPECT_TRUE(std::equal(hidden.begin(), hidden.end(), expected.begin(), expected.end()));
    least = std::min(least, plain);
    most = std::max(most, plain);
  }
  EXPECT_LT(least, -500); // it does not say the same of all
  EXPECT_GT(most, 500);
}

TEST(SignNetwork, NoSumExceedsItsType)
{
  for (std::size_t i = 0; i < SignNetworkWeights::Width; ++i)
  {
    int sum = 0;
    for (const auto& weights : LearntSignNetwork.First)
    {
      sum += std::abs(weights[i]);
    }
    EXPECT_LE(sum, 32767) << i;
  }
  std::int64_t third = std::abs(LearntSignNetwork.ThirdAdded);
  for (std::size_t n = 0; n < SignNetworkWeights::Depth; ++n)
  {
    std::int64_t second = std::abs(LearntSignNetwork.SecondAdded[n]);
    for (const std::int16_t weight : LearntSignNetwork.Second[n])
    {
      second += 2047 * std::abs(weight);
    }
    EXPECT_LT(second, std::int64_t{ 1 } << 31) << n;
    third += 2047 * std::abs(LearntSignNetwork.Third[n]);
  }
  EXPECT_LT(third, std::int64_t{ 1 } << 31);
}

TEST(WideMixer, LearnsWhichInputIsRight)
{
  std::mt19937 random(4);
  WideMixer mixer{};
  WideMixer::Values inputs{};
  for (int round = 0; round < 2000; ++round)
  {
    const bool bit = random() % 2 == 0;
    std::generate(inputs.begin(), inputs.end(),
      [&] { return static_cast<std::int16_t>(static_cast<int>(random() % 1001) - 500); });
    inputs[17] = bit ? 700 : -700;
    mixer.Update(inputs, mixer.Mix(inputs), bit);
  }
  const auto greatest = std::max_element(mixer.Weights.begin(), mixer.Weights.end());
  EXPECT_EQ(greatest - mixer.Weights.begin(), 17);
  EXPECT_GT(*greatest, 1 << 14);
}

TEST(WideMixer, HoldsWhateverItIsTold)
{
  for (const int sign : { -1, 1 })
  {
    WideMixer mixer{};
    WideMixer::Values inputs;
    inputs.fill(static_cast<std::int16_t>(2047 * sign));
    for (int round = 0; round < 100; ++round)
    {
      mixer.Update(inputs, sign > 0 ? -2047 : 2047, sign > 0);
    }
    EXPECT_EQ(mixer.Weights[5], 32767);
    EXPECT_EQ(mixer.Mix(inputs), 2047 * sign);
    inputs.fill(static_cast<std::int16_t>(-2047 * sign));
    EXPECT_EQ(mixer.Mix(inputs), -2047 * sign);
  }
}
