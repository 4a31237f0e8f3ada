// SPDX-License-Identifier: BSD-3-Clause
// The oracle is least squares in double precision, by elimination.
#include "Coding/Prediction/HeightFit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

constexpr std::size_t Size = 6;

struct Pair
{
  std::array<std::int16_t, Size> Inputs;
  std::int16_t Target;
};

/// Inputs that are alike, as neighbours are, and a target that is about a mean of them.
std::vector<Pair> MakePairs(std::size_t number)
{
  std::mt19937 random(11);
  const auto draw = [&random](int most)
  { return static_cast<int>(random() % (2 * most + 1)) - most; };
  std::vector<Pair> pairs(number);
  for (Pair& pair : pairs)
  {
    const int common = draw(2500);
    for (std::int16_t& input : pair.Inputs)
    {
      input = static_cast<std::int16_t>(common + draw(300));
    }
    pair.Target = static_cast<std::int16_t>(
      (3 * pair.Inputs[0] + 2 * pair.Inputs[1] - pair.Inputs[4]) / 4 + draw(20));
  }
  return pairs;
}

/// The weights of least error, older batches of 8 counting 7/8 of the one after; none before.
std::array<double, Size> FitExactly(const std::vector<Pair>& pairs)
{
  double a[Size][Size + 1] = {};
  for (std::size_t n = 0; n < pairs.size(); ++n)
  {
    for (std::size_t i = 0; i < Size; ++i)
    {
      for (std::size_t j = 0; j <= Size; ++j)
      {
        a[i][j] *= n % 8 == 0 ? 0.875 : 1;
        a[i][j] += pairs[n].Inputs[i] * double(j < Size ? pairs[n].Inputs[j] : pairs[n].Target);
      }
    }
  }
  for (std::size_t k = 0; k < Size; ++k)
  {
    for (std::size_t i = 0; i < Size; ++i)
    {
      const double factor = i == k ? 0 : a[i][k] / a[k][k];
      for (std::size_t j = k; j <= Size; ++j)
      {
        a[i][j] -= factor * a[k][j];
      }
    }
  }
  std::array<double, Size> weights{};
  for (std::size_t k = 0; k < Size; ++k)
  {
    weights[k] = a[k][Size] / a[k][k];
  }
  return weights;
}

using Sums = std::array<std::array<std::int32_t, Size + 1>, Size + 1>;

void Add(const Pair* pairs, LinearFit<Size>& fit)
{
  Sums sums{};
  for (std::size_t n = 0; n < 8; ++n)
  {
    std::array<std::int32_t, Size + 1> all;
    std::copy(pairs[n].Inputs.begin(), pairs[n].Inputs.end(), all.begin());
    all[Size] = pairs[n].Target;
    for (std::size_t i = 0; i <= Size; ++i)
    {
      for (std::size_t j = 0; j <= i; ++j)
      {
        sums[i][j] += all[i] * all[j];
      }
    }
  }
  fit.Add(sums, Size, 3);
}

} // namespace

TEST(LinearFit, PredictsLikeLeastSquaresInDoublePrecision)
{
  const std::vector<Pair> pairs = MakePairs(800);
  const std::array<std::int32_t, Size> first{};
  LinearFit<Size> fit;
  fit.Begin(first.data(), 1000);
  for (std::size_t n = 0; n < pairs.size(); n += 8)
  {
    Add(&pairs[n], fit);
  }
  fit.Solve();
  const std::array<double, Size> weights = FitExactly(pairs);
  for (const Pair& pair : pairs)
  {
    double expected = 0;
    for (std::size_t n = 0; n < Size; ++n)
    {
      expected += weights[n] * pair.Inputs[n];
    }
    // The ridge pulls a little towards 0.
    ASSERT_NEAR(fit.Predict(pair.Inputs.data()) / 16.0, expected, 8);
  }
}

TEST(LinearFit, StartsWithTheGivenWeights)
{
  const std::array<std::int32_t, Size> first{ 1 << 16, 1 << 15, 0, -(1 << 14), 0, 0 };
  LinearFit<Size> fit;
  fit.Begin(first.data(), 3000000);
  const std::array<std::int16_t, Size> inputs{ 1000, 500, 77, 400, -3, 9 };
  EXPECT_EQ(fit.Predict(inputs.data()), 16 * (1000 + 250 - 100));
  fit.Solve();
  EXPECT_NEAR(fit.Predict(inputs.data()), 16 * (1000 + 250 - 100), 16);
}

TEST(HeightFit, FollowsARelationThatChanges)
{
  std::mt19937 random(3);
  HeightFit fit(std::array<std::int32_t, HeightFit::NumberOfInputs>{});
  for (int n = 0; n < 3000; ++n)
  {
    std::int16_t* inputs = fit.GetInputs();
    for (int k = 0; k < HeightFit::NumberOfInputs; ++k)
    {
      inputs[k] = static_cast<std::int16_t>(static_cast<int>(random() % 2001) - 1000);
    }
    const int height = n < 2000 ? (inputs[0] + inputs[9]) / 2 : (2 * inputs[1] - inputs[5]) / 3;
    const int error = std::abs(fit.Predict() - height);
    if ((n > 600 && n < 2000) || n > 2400)
    {
      ASSERT_LT(error, 40) << n;
    }
    fit.Learn(height);
  }
}

TEST(HeightFit, ExtremesDoNotOverflow)
{
  std::mt19937 random(4);
  std::array<std::int32_t, HeightFit::NumberOfInputs> weights{};
  weights[0] = 1 << 16;
  HeightFit fit(weights);
  for (int n = 0; n < 8000; ++n)
  {
    std::int16_t* inputs = fit.GetInputs();
    for (int k = 0; k < HeightFit::NumberOfInputs; ++k)
    {
      // All alike; then of any sign; then nothing but the last one.
      const bool positive = n < 2000 || (n < 4000 && random() % 2 == 0);
      const int height = n < 4000 || k == 23 ? 4095 : n < 6000 ? 0 : static_cast<int>(random() % 2);
      inputs[k] = static_cast<std::int16_t>(positive ? height : -height);
    }
    ASSERT_LE(std::abs(fit.Predict()), 8192);
    fit.Learn(random() % 2 == 0 ? 4094 : -4094);
  }
}
