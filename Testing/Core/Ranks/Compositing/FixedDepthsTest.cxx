// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/FixedDepths.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

using namespace isosurface;

TEST(FixedDepths, BecomeFloatsWhereverTheyStand)
{
  constexpr std::uint32_t farthest = 0xffffffffU;
  std::vector<std::uint32_t> fixed = { 0, 1, 0x7fffffffU, 0x80000000U, 0xfffffeffU, 0xffffff7fU,
    0xffffff80U, farthest - 1 };
  std::mt19937 random(61);
  while (fixed.size() < 5000)
  {
    // Empty stretches of different lengths, so that some blocks are empty and some nearly.
    fixed.insert(fixed.end(), random() % 80, farthest);
    fixed.push_back(random());
  }
  for (const std::size_t first : { 0, 1, 31 })
  {
    std::vector<float> depths(fixed.size() - first);
    std::memcpy(depths.data(), fixed.data() + first, depths.size() * sizeof(float));
    ConvertFixedDepths(depths.data(), depths.size());
    for (std::size_t n = 0; n < depths.size(); ++n)
    {
      const double quotient = static_cast<double>(fixed[first + n]) / farthest;
      ASSERT_EQ(depths[n], static_cast<float>(quotient)) << fixed[first + n];
    }
  }
}
