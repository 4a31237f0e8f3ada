// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NetworkSigns_h
#define isosurface_NetworkSigns_h

#include "EdgeIndex/AdaptiveModels.h"
#include "EdgeIndex/SignCoder.h"
#include "EdgeIndex/SignNeighborhood.h"
#include "EdgeIndex/SignNetwork.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Squash of what is within -2047 .. 2047, without a call.
inline std::uint32_t GetSquashed(int x)
{
  return Tables.Squash[static_cast<std::size_t>(x + 2048)];
}

/// LogisticMixer of 32 inputs; what it mixes are not probabilities alone.
struct WideMixer
{
  static constexpr std::size_t Size = 32;
  using Values = std::array<std::int16_t, Size>;

  alignas(32) Values Weights; ///< in units of 2^-14

  /// A stretched probability of inputs within -2047 .. 2047.
  int Mix(const Values& inputs) const
  {
    int sum = 0;
    for (std::size_t n = 0; n < Size; ++n)
    {
      sum += inputs[n] * this->Weights[n];
    }
    sum >>= 14;
    return sum < -2047 ? -2047 : sum > 2047 ? 2047 : sum;
  }

  /// Learns from the bit that came, Mix having been `stretched`.
  void Update(const Values& inputs, int stretched, bool bit)
  {
    const int error = ((bit ? 65535 : 0) - static_cast<int>(GetSquashed(stretched))) >> 1;
    for (std::size_t n = 0; n < Size; ++n)
    {
      const int weight = this->Weights[n] + ((inputs[n] * error + 0x4000) >> 15);
      this->Weights[n] = static_cast<std::int16_t>(weight < -32767 ? -32767
          : weight > 32767                                         ? 32767
                                                                   : weight);
    }
  }
};

/// What is known about the signs of vertices, in the profile Compact.
struct NetworkSignModel
{
  static constexpr std::size_t NumberOfContexts = 8;
  /// How many bits the index of each context has.
  static constexpr std::array<int, NumberOfContexts> ContextBits = { 12, 14, 14, 14, 14, 14, 10,
    9 };
  static constexpr std::size_t NumberOfLevels = 8;
  /// How many mixers there are of each kind: by how well signs are predicted lately and five
  /// neighbours, by what the network predicts, and by neighbours two slices before, twice.
  static constexpr std::size_t NumberOfKinds = 4;
  static constexpr std::array<std::size_t, NumberOfKinds> KindSizes = { NumberOfLevels * 32, 32, 32,
    64 };

  /// Empty if not `used`.
  explicit NetworkSignModel(bool used);

  QuietSigns Quiet;
  /// A probability in each context. One that did not occur yet (of no updates) stands for that of
  /// the network, which it begins with.
  std::array<std::vector<AdaptiveBit>, NumberOfContexts> Contexts;
  std::array<std::vector<WideMixer>, NumberOfKinds> Mixers;
  /// The mean error of probabilities, which are of 16 bits, lately; times 128.
  std::uint32_t MeanError = 128 * 8192;
};

/**
 * Codes the sign of a vertex: a network, learnt beforehand and the same for all surfaces, predicts
 * it; probabilities in eight contexts learn how this block differs from that, and four mixers what
 * to make of them, and of the network's second hidden layer. The mean of what the mixers say
 * counts.
 */
template <typename Coder>
class NetworkSigns
{
public:
  using Model = NetworkSignModel;

  NetworkSigns(Coder& coder, NetworkSignModel& model)
    : Output(coder)
    , Known(model)
    , Network(GetSignNetwork())
    , Sums(Network.MakeRow(Around.GetRow()))
  {
  }

  void BeginRow(const SignRowPlace& place)
  {
    if (this->Around.BeginRow(place))
    {
      this->Sums = this->Network.MakeRow(this->Around.GetRow());
    }
  }

  /// Codes vertex x; own: the signs at x - 2 and x - 1, lowest first; `row` is decoded up to x.
  bool CodeVertex(
    bool bit, std::uint32_t own, const SignRow& row, const SignRowsAround& rows, int x)
  {
    const bool flipped = own >> 1 != 0;
    const SignNetworkInputs seen = this->Around.Find(flipped, row, rows, x);
    alignas(32) WideMixer::Values inputs{};
    std::array<std::int16_t, SignNetwork::Depth> hidden;
    const int predicted = this->Network.Predict(this->Sums, seen, hidden);
    for (std::size_t n = 0; n < hidden.size(); ++n)
    {
      inputs[n] = static_cast<std::int16_t>(hidden[n] >> 1);
    }
    const Places places = this->FindPlaces(seen, predicted);
    std::array<AdaptiveBit*, NetworkSignModel::NumberOfContexts> contexts;
    for (std::size_t n = 0; n < contexts.size(); ++n)
    {
      contexts[n] = &this->Known.Contexts[n][places.Contexts[n]];
      inputs[SignNetwork::Depth + n] = Compare(*contexts[n], predicted);
    }
    inputs[SignNetwork::Depth + contexts.size()] = static_cast<std::int16_t>(predicted);
    inputs[SignNetwork::Depth + contexts.size() + 1] = 64;

    std::array<WideMixer*, NetworkSignModel::NumberOfKinds> mixers;
    std::array<int, NetworkSignModel::NumberOfKinds> mixed;
    int sum = 0;
    for (std::size_t n = 0; n < mixers.size(); ++n)
    {
      mixers[n] = &this->Known.Mixers[n][places.Mixers[n]];
      mixed[n] = mixers[n]->Mix(inputs);
      sum += mixed[n];
    }
    const std::uint32_t probability = GetSquashed(sum >> 2);
    const bool coded = this->Output.CodeBit(bit != flipped, probability);
    for (std::size_t n = 0; n < mixers.size(); ++n)
    {
      mixers[n]->Update(inputs, mixed[n], coded);
    }
    for (AdaptiveBit* context : contexts)
    {
      context->Update(coded, MostCount);
    }
    const std::uint32_t error = coded ? 65536 - probability : probability;
    this->Known.MeanError += error - (this->Known.MeanError >> 7);
    return coded != flipped;
  }

private:
  static constexpr std::uint32_t MostCount = 200;

  // Where the probabilities and weights for a vertex are.
  struct Places
  {
    std::array<std::uint32_t, NetworkSignModel::NumberOfContexts> Contexts;
    std::array<std::uint32_t, NetworkSignModel::NumberOfKinds> Mixers;
  };

  static std::uint32_t Hash(std::uint32_t low, std::uint32_t high)
  {
    const std::uint32_t key = (low * 0x9E3779B1u ^ high) * 0x85EBCA6Bu;
    return (key ^ key >> 15) >> 3 & ((1u << 14) - 1);
  }

  Places FindPlaces(const SignNetworkInputs& seen, int predicted) const
  {
    using Inputs = SignNetworkInputs;
    const auto get = [&seen](Inputs::Pattern pattern, int first, int bits)
    { return std::uint32_t{ seen.Patterns[pattern] } >> first & ((1u << bits) - 1); };
    const auto count = [](std::uint32_t bits)
    { return static_cast<std::uint32_t>(__builtin_popcount(bits)); };
    const std::uint32_t near = get(Inputs::Y, 2, 3) | get(Inputs::Z, 2, 3) << 3 |
      get(Inputs::ZM, 2, 3) << 6 | get(Inputs::ZP, 2, 3) << 9;
    const std::uint32_t left2 = get(Inputs::Own, 2, 1);
    const std::uint32_t out = left2 | get(Inputs::YY, 3, 1) << 1 | get(Inputs::ZZ, 3, 1) << 2 |
      get(Inputs::Y, 1, 1) << 3 | get(Inputs::Y, 5, 1) << 4 | get(Inputs::Z, 1, 1) << 5 |
      get(Inputs::Z, 5, 1) << 6;
    const std::uint32_t core =
      get(Inputs::Y, 3, 2) | get(Inputs::Z, 3, 2) << 2 | get(Inputs::ZP, 3, 1) << 4;
    const std::uint32_t nearCount = count(near);
    const std::uint32_t farCount = count(out) + count(get(Inputs::YY, 1, 5)) +
      count(get(Inputs::ZZ, 1, 5)) + count(get(Inputs::ZMM, 0, 5)) + count(get(Inputs::ZPP, 0, 5));
    const std::uint32_t step = static_cast<std::uint32_t>(predicted + 2048) >> 7;
    const std::uint32_t level =
      std::min<std::uint32_t>(this->Known.MeanError >> 18, NetworkSignModel::NumberOfLevels - 1);
    const std::uint32_t sides = get(Inputs::ZMM, 2, 1) | get(Inputs::ZPP, 2, 1) << 1 |
      get(Inputs::YY, 2, 1) << 2 | get(Inputs::YY, 4, 1) << 3 | get(Inputs::ZZ, 2, 1) << 4 |
      get(Inputs::ZZ, 4, 1) << 5;
    const std::uint32_t behind = get(Inputs::ZZ, 2, 3) | get(Inputs::ZZM, 2, 1) << 3 |
      get(Inputs::ZZP, 2, 1) << 4 | get(Inputs::YY, 2, 3) << 5 | left2 << 8;
    const std::uint32_t wide = get(Inputs::ZMM, 1, 3) | get(Inputs::ZPP, 1, 3) << 3 |
      get(Inputs::YY, 2, 3) << 6 | get(Inputs::Own, 3, 1) << 9;
    return { { near, Hash(near, out), Hash(near | out << 12, sides | 64),
               nearCount | farCount << 4 | core << 9, Hash(near, behind | 512),
               Hash(core | out << 5, wide | 1024), step << 5 | core, step << 4 | nearCount },
      { level << 5 | core, step, get(Inputs::ZZ, 1, 5),
        get(Inputs::ZZM, 1, 3) | get(Inputs::ZZP, 1, 3) << 3 } };
  }

  // How much more likely another sign is in a context than the network says, and how sure that is:
  // by n / (n + 3/2) after n updates.
  static std::int16_t Compare(AdaptiveBit& context, int predicted)
  {
    const std::uint32_t count = context.State & 1023;
    if (count == 0)
    {
      context.State = GetSquashed(predicted) << 16;
      return 0;
    }
    const int difference = Tables.Stretch[context.State >> 20] - predicted;
    const auto share = static_cast<int>(8192 * count / (2 * count + 3)); // in units of 2^-12
    return static_cast<std::int16_t>(std::clamp(difference * share >> 12, -2047, 2047));
  }

  Coder& Output;
  NetworkSignModel& Known;
  const SignNetwork& Network;
  SignNeighborhood Around;
  alignas(32) SignNetwork::Sums Sums; ///< of the row
};

} // namespace isosurface

#endif
