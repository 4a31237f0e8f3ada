// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EntropyCoding/RangeCoder.h"
#include "Coding/EntropyCoding/AdaptiveModels.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

struct Decision
{
  int Kind;
  std::uint32_t Number;
  std::uint32_t Argument;
};

template <typename Coder>
std::uint32_t Apply(Coder& coder, const Decision& decision)
{
  if (decision.Kind == 0)
  {
    return coder.CodeBit(decision.Number != 0, decision.Argument) ? 1 : 0;
  }
  if (decision.Kind == 1)
  {
    return coder.CodeUniform(decision.Number, static_cast<int>(decision.Argument));
  }
  std::array<std::int16_t, NumberOfSymbols> cumulative{};
  for (std::size_t n = 1; n < cumulative.size(); ++n)
  {
    const int width = n - 1 == decision.Argument ? (1 << FrequencyBits) - 15 : 1;
    cumulative[n] = static_cast<std::int16_t>(cumulative[n - 1] + width);
  }
  return static_cast<std::uint32_t>(
    coder.CodeSymbol(static_cast<int>(decision.Number), cumulative.data()));
}

std::vector<Decision> MakeDecisions(unsigned seed)
{
  std::mt19937 random(seed);
  std::vector<Decision> decisions;
  for (int n = 0; n < 20000; ++n)
  {
    Decision decision{ static_cast<int>(random() % 3), 0, 0 };
    if (decision.Kind == 0)
    {
      // Certain and uncertain ones; now and then the unlikely comes.
      decision.Argument = random() % 2 != 0 ? 1 + random() % 65535 : random() % 2 != 0 ? 65535 : 1;
      decision.Number = random() % 65536 < decision.Argument ? 1 : 0;
    }
    else if (decision.Kind == 1)
    {
      decision.Argument = random() % 17;
      decision.Number = random() & ((1u << decision.Argument) - 1);
    }
    else
    {
      decision.Argument = random() % 16;
      decision.Number = random() % 3 != 0 ? decision.Argument : random() % 16;
    }
    decisions.push_back(decision);
  }
  return decisions;
}

} // namespace

TEST(RangeCoder, DecodesWhatWasEncodedAndReadsAllBytes)
{
  for (unsigned seed = 0; seed < 40; ++seed)
  {
    const std::vector<Decision> decisions = MakeDecisions(seed);
    std::vector<std::uint8_t> bytes;
    RangeEncoder encoder(bytes);
    for (const Decision& decision : decisions)
    {
      Apply(encoder, decision);
    }
    encoder.Finish();
    RangeDecoder decoder(bytes.data(), bytes.size());
    for (const Decision& decision : decisions)
    {
      ASSERT_EQ(Apply(decoder, decision), decision.Number);
    }
    EXPECT_FALSE(decoder.IsExhausted());
    EXPECT_FALSE(decoder.HasMore());
  }
}

TEST(RangeCoder, KeepsEarlierBytes)
{
  std::vector<std::uint8_t> bytes = { 255, 255, 255 };
  RangeEncoder encoder(bytes);
  for (int n = 0; n < 1000; ++n)
  {
    encoder.CodeBit(false, 65535); // as far up as it goes, so that carries come
    encoder.CodeUniform(65535, 16);
  }
  encoder.Finish();
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + 3),
    (std::vector<std::uint8_t>{ 255, 255, 255 }));
}

TEST(RangeCoder, CodesInAboutTheEntropy)
{
  std::vector<std::uint8_t> bytes;
  RangeEncoder encoder(bytes);
  std::mt19937 random(3);
  AdaptiveBit model;
  for (int n = 0; n < 100000; ++n)
  {
    CodeAdaptive(encoder, model, random() % 16 == 0, 1000);
  }
  encoder.Finish();
  const double entropy = 0.3373 * 100000 / 8; // of one in sixteen
  EXPECT_NEAR(static_cast<double>(bytes.size()), entropy, 0.02 * entropy);
}

TEST(LogisticMixer, SaturatesAtTheSameProbabilityWithAndWithoutVectors)
{
  EXPECT_EQ(Tables.Squash[0], Tables.Squash[1]);
}

TEST(AdaptiveBit, ManyLearnTogetherAsEachAlone)
{
  std::mt19937 random(11);
  for (std::uint32_t count = 0; count < 1024; ++count)
  {
    for (const bool bit : { false, true })
    {
      std::array<AdaptiveBit, 6> together;
      std::array<AdaptiveBit*, 6> models{};
      for (std::size_t n = 0; n < together.size(); ++n)
      {
        const std::uint32_t probability = n == 0 ? 0 : n == 1 ? (1u << 22) - 1 : random() >> 10;
        together[n].State = probability << 10 | count;
        models[n] = &together[n];
      }
      std::array<AdaptiveBit, 6> alone = together;
      UpdateAll<6>(models.data(), 0, bit, 800);
      for (std::size_t n = 0; n < together.size(); ++n)
      {
        alone[n].Update(bit, 800);
        ASSERT_EQ(together[n].State, alone[n].State) << "count " << count;
      }
    }
  }
}

TEST(RangeCoder, AnyBytesDecodeAndExhaustionIsFound)
{
  const std::vector<Decision> decisions = MakeDecisions(5);
  for (const std::size_t size : { 0, 1, 5, 100 })
  {
    const std::vector<std::uint8_t> bytes(size, 255);
    RangeDecoder decoder(bytes.data(), bytes.size());
    for (const Decision& decision : decisions)
    {
      const std::uint32_t number = Apply(decoder, decision);
      ASSERT_LT(number, decision.Kind == 1 ? 1u << decision.Argument : 16u);
    }
    EXPECT_TRUE(decoder.IsExhausted());
  }
}

TEST(AdaptiveSymbol, NoSymbolBecomesImpossible)
{
  AdaptiveSymbol model;
  for (int n = 0; n < 100000; ++n)
  {
    model.Update(n < 50000 ? 3 : 15);
    for (int symbol = 0; symbol < NumberOfSymbols; ++symbol)
    {
      ASSERT_GE(GetShare(model.Cumulative.data(), symbol), 8u);
    }
  }
}
