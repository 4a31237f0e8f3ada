// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EntropyCoding/WideMixer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>

using namespace isosurface;

TEST(WideMixer, LearnsWhichInputPredictsTheBit)
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
  const auto maximum = std::max_element(mixer.Weights.begin(), mixer.Weights.end());
  EXPECT_EQ(maximum - mixer.Weights.begin(), 17);
  EXPECT_GT(*maximum, 1 << 14);
}

TEST(WideMixer, WeightsSaturate)
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
