// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/TrainedModels/SignNetwork.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

/// Evaluates the network bit by bit, as Documentation/formats/edge-index.md describes it.
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

TEST(SignNetwork, LookedUpSumsAreThoseOfTheWeights)
{
  std::mt19937 random(3);
  const SignNetwork& network = GetSignNetwork();
  int minimum = 2047;
  int maximum = -2047;
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
    const int plain = PredictPlainly(GetTrainedWeights(), row, inputs, expected);
    std::array<std::int16_t, SignNetwork::Depth> hidden{};
    EXPECT_EQ(network.Predict(network.MakeRow(row), inputs, hidden), plain);
    EXPECT_TRUE(std::equal(hidden.begin(), hidden.end(), expected.begin(), expected.end()));
    minimum = std::min(minimum, plain);
    maximum = std::max(maximum, plain);
  }
  EXPECT_LT(minimum, -500); // predictions differ
  EXPECT_GT(maximum, 500);
}

TEST(SignNetwork, NoSumOfTheTrainedWeightsOverflows)
{
  for (std::size_t i = 0; i < SignNetworkWeights::Width; ++i)
  {
    int sum = 0;
    for (const auto& weights : GetTrainedWeights().First)
    {
      sum += std::abs(weights[i]);
    }
    EXPECT_LE(sum, 32767) << i;
  }
  std::int64_t third = std::abs(GetTrainedWeights().ThirdAdded);
  for (std::size_t n = 0; n < SignNetworkWeights::Depth; ++n)
  {
    std::int64_t second = std::abs(GetTrainedWeights().SecondAdded[n]);
    for (const std::int16_t weight : GetTrainedWeights().Second[n])
    {
      second += 2047 * std::abs(weight);
    }
    EXPECT_LT(second, std::int64_t{ 1 } << 31) << n;
    third += 2047 * std::abs(GetTrainedWeights().Third[n]);
  }
  EXPECT_LT(third, std::int64_t{ 1 } << 31);
}
