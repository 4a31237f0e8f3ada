// SPDX-License-Identifier: BSD-3-Clause
// The coders are compiled for two instruction sets; both must write and read the same bytes.
#include "Coding/BlockCoding/BlockCoding.h"
#include "Coding/BlockCoding/BytePlanes.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <random>
#include <tuple>
#include <vector>

using namespace isosurface;

namespace
{

/// Gives a number for each place that is asked for, or remembers the decoded ones.
class RememberedBlock : public BlockValues
{
public:
  std::vector<SignSlice> Signs;
  std::map<std::tuple<int, int, int, int>, std::int64_t> Numbers; ///< by axis (3: values), x, y, z
  bool Gives = false;

  SignSlice& GetSigns(int z) override { return this->Signs[static_cast<std::size_t>(z)]; }
  void FinishSigns(int) override {}
  bool FinishSlice(int) override { return true; }
  void ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes) override
  {
    VisitBits(vertices, [&](int x) { this->Exchange(3, x, y, z, codes[x]); });
  }
  void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) override
  {
    VisitBits(edges, [&](int x) { this->Exchange(axis, x, y, z, bins[x]); });
  }

private:
  template <typename Number>
  void Exchange(int axis, int x, int y, int z, Number& number)
  {
    std::int64_t& own = this->Numbers[{ axis, x, y, z }];
    if (this->Gives)
    {
      const int wave = (7 * x + 5 * y + 3 * z) % 23 * 5 + axis;
      const bool inside = this->Signs[static_cast<std::size_t>(z)].At(y).Get(x);
      own = axis < 3 ? wave % 100 : inside ? wave : -1 - wave;
      number = static_cast<Number>(own);
    }
    else
    {
      own = number;
    }
  }
};

constexpr std::array<int, 3> Size = { 65, 20, 12 };

std::vector<SignSlice> MakeSigns()
{
  std::mt19937 random(5);
  std::vector<SignSlice> signs(static_cast<std::size_t>(Size[2]));
  for (int z = 0; z < Size[2]; ++z)
  {
    for (int y = 0; y < Size[1]; ++y)
    {
      for (int x = 0; x < Size[0]; ++x)
      {
        const int distance = (x - 30) * (x - 30) / 9 + (y - 10) * (y - 10) + (z - 6) * (z - 6);
        if ((distance < 60) != (random() % 40 == 0))
        {
          signs[static_cast<std::size_t>(z)].At(y).Set(x);
        }
      }
    }
  }
  return signs;
}

} // namespace

TEST(BlockCoding, BothInstructionSetsGiveTheSameBytesAndNumbers)
{
  for (const auto profile : { EdgeIndexProfile::Small, EdgeIndexProfile::Preview })
  {
    for (const bool hasValues : { false, true })
    {
      if (hasValues && profile == EdgeIndexProfile::Preview)
      {
        continue; // previews have no values
      }
      const auto domain = std::make_unique<ValueDomain>(ValueType::Int16, 0.0, 3);
      BlockContent content;
      content.Size = Size;
      content.Domain = hasValues ? domain.get() : nullptr;
      content.Intervals = CrossingIntervals::MakeEqual(100);
      std::vector<std::uint8_t> bytes[2];
      RememberedBlock given;
      for (int n = 0; n < 2; ++n)
      {
        given.Gives = true;
        given.Signs = MakeSigns();
        BlockModel model = GetFreshModel(profile);
        RangeEncoder encoder(bytes[n]);
        CodeBlock(encoder, model, content, given,
          n == 0 ? CoderInstructions::Baseline : CoderInstructions::Newest);
        encoder.Finish();
      }
      EXPECT_EQ(bytes[0], bytes[1]);
      EXPECT_GT(given.Numbers.size(), 1000u);
      for (const CoderInstructions instructions :
        { CoderInstructions::Baseline, CoderInstructions::Newest })
      {
        RememberedBlock taken;
        taken.Signs.resize(static_cast<std::size_t>(Size[2]));
        BlockModel model = GetFreshModel(profile);
        RangeDecoder decoder(bytes[0].data(), bytes[0].size());
        CodeBlock(decoder, model, content, taken, instructions);
        EXPECT_EQ(given.Numbers, taken.Numbers);
        EXPECT_FALSE(decoder.IsExhausted());
        EXPECT_FALSE(decoder.HasMore());
      }
    }
  }
}

TEST(BlockCoding, PlanesOfBothInstructionSetsHaveTheSameBytesAndNumbers)
{
  for (const bool hasValues : { false, true })
  {
    const auto domain = std::make_unique<ValueDomain>(ValueType::Int16, 0.0, 3);
    BlockContent content;
    content.Size = Size;
    content.Domain = hasValues ? domain.get() : nullptr;
    content.Intervals = CrossingIntervals::MakeEqual(100);
    BytePlanes planes;
    content.Planes = &planes;
    BlockModel model = GetFreshModel(EdgeIndexProfile::Working);
    std::vector<std::uint8_t> bytes[2];
    std::vector<std::uint8_t> unused;
    RememberedBlock given;
    for (int n = 0; n < 2; ++n)
    {
      given.Gives = true;
      given.Signs = MakeSigns();
      RangeEncoder encoder(unused);
      planes.Begin(Size);
      CodeBlock(encoder, model, content, given,
        n == 0 ? CoderInstructions::Baseline : CoderInstructions::Newest);
      planes.Append(bytes[n]);
    }
    EXPECT_EQ(bytes[0], bytes[1]);
    EXPECT_TRUE(unused.empty());
    EXPECT_GT(given.Numbers.size(), 1000u);
    for (const CoderInstructions instructions :
      { CoderInstructions::Baseline, CoderInstructions::Newest })
    {
      RememberedBlock taken;
      taken.Signs.resize(static_cast<std::size_t>(Size[2]));
      EXPECT_EQ(planes.Begin(Size, bytes[0].data(), bytes[0].size()), bytes[0].size());
      RangeDecoder decoder(nullptr, 0);
      CodeBlock(decoder, model, content, taken, instructions);
      EXPECT_EQ(given.Numbers, taken.Numbers);
      EXPECT_TRUE(planes.IsComplete());
    }
  }
}
