// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NetworkSigns_h
#define isosurface_NetworkSigns_h

#include "Coding/BlockCoding/SignCoder.h"
#include "Coding/BlockCoding/SignNeighborhood.h"
#include "Coding/EntropyCoding/AdaptiveModels.h"
#include "Coding/EntropyCoding/WideMixer.h"
#include "Coding/TrainedModels/SignNetwork.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// What is learnt about the signs of a block in the profile compact.
struct NetworkSignModel
{
  static constexpr std::size_t NumberOfContexts = 8;
  /// Bits of the index in each context.
  static constexpr std::array<int, NumberOfContexts> ContextBits = { 12, 14, 14, 14, 14, 14, 10,
    9 };
  static constexpr std::size_t NumberOfLevels = 8;
  /// Numbers of mixers of the four kinds. They are chosen by the mean error and five neighbours, by
  /// the network's prediction, and twice by neighbours two slices before.
  static constexpr std::size_t NumberOfKinds = 4;
  static constexpr std::array<std::size_t, NumberOfKinds> KindSizes = { NumberOfLevels * 32, 32, 32,
    64 };

  /// Empty if not `used`.
  explicit NetworkSignModel(bool used);

  QuietSigns Quiet;
  /// Probabilities in each context. One without updates stands for the network's prediction, which
  /// it begins with.
  std::array<std::vector<AdaptiveBit>, NumberOfContexts> Contexts;
  std::array<std::vector<WideMixer>, NumberOfKinds> Mixers;
  /// The mean error of recent probabilities, in units of 2^-23. It begins with 1/8.
  std::uint32_t MeanError = 128 * 8192;
};

/**
 * Codes the sign of a vertex. A trained network, the same for all surfaces, predicts it.
 * Probabilities in eight contexts learn how this block differs from the prediction. Four mixers
 * combine the prediction, the contexts and the network's second hidden layer; their mean is the
 * probability.
 */
template <typename Coder>
class NetworkSigns
{
public:
  using Model = NetworkSignModel;

  explicit NetworkSigns(NetworkSignModel& model)
    : Known(model)
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

  /// Codes the sign of vertex x. own: the signs at x - 2 (bit 0) and x - 1; row: decoded up to x.
  bool CodeVertex(Coder& coder, bool bit, std::uint32_t own, const SignRow& row,
    const SignRowsAround& rows, int x)
  {
    const bool flipped = own >> 1 != 0;
    const SignNetworkInputs seen = this->Around.Find(flipped, row, rows, x);
    alignas(32) WideMixer::Values inputs{};
    const int predicted = this->PredictByNetwork(seen, inputs);
    const Indices indices = this->FindIndices(seen, predicted);
    Contexts contexts;
    for (std::size_t n = 0; n < contexts.size(); ++n)
    {
      contexts[n] = &this->Known.Contexts[n][indices.Contexts[n]];
      inputs[SignNetwork::Depth + n] = Compare(*contexts[n], predicted);
    }
    return this->CodeMixed(coder, bit != flipped, inputs, contexts, indices) != flipped;
  }

private:
  static constexpr std::uint32_t CountLimit = 200;

  using Contexts = std::array<AdaptiveBit*, NetworkSignModel::NumberOfContexts>;

  // Of the probabilities and mixers of a vertex in their tables.
  struct Indices
  {
    std::array<std::uint32_t, NetworkSignModel::NumberOfContexts> Contexts;
    std::array<std::uint32_t, NetworkSignModel::NumberOfKinds> Mixers;
  };

  // The network's prediction; sets the inputs of the mixers that follow from it.
  int PredictByNetwork(const SignNetworkInputs& seen, WideMixer::Values& inputs) const
  {
    std::array<std::int16_t, SignNetwork::Depth> hidden;
    const int predicted = this->Network.Predict(this->Sums, seen, hidden);
    for (std::size_t n = 0; n < hidden.size(); ++n)
    {
      inputs[n] = static_cast<std::int16_t>(hidden[n] >> 1);
    }
    constexpr std::size_t next = SignNetwork::Depth + NetworkSignModel::NumberOfContexts;
    inputs[next] = static_cast<std::int16_t>(predicted);
    inputs[next + 1] = 64;
    return predicted;
  }

  // Codes a bit with the mean of four mixers; mixers and contexts learn it.
  bool CodeMixed(Coder& coder, bool bit, const WideMixer::Values& inputs, const Contexts& contexts,
    const Indices& indices)
  {
    std::array<WideMixer*, NetworkSignModel::NumberOfKinds> mixers;
    std::array<int, NetworkSignModel::NumberOfKinds> mixed;
    int sum = 0;
    for (std::size_t n = 0; n < mixers.size(); ++n)
    {
      mixers[n] = &this->Known.Mixers[n][indices.Mixers[n]];
      mixed[n] = mixers[n]->Mix(inputs);
      sum += mixed[n];
    }
    const std::uint32_t probability = GetSquashed(sum >> 2);
    bit = coder.CodeBit(bit, probability);
    for (std::size_t n = 0; n < mixers.size(); ++n)
    {
      mixers[n]->Update(inputs, mixed[n], bit);
    }
    for (AdaptiveBit* context : contexts)
    {
      context->Update(bit, CountLimit);
    }
    const std::uint32_t error = bit ? 65536 - probability : probability;
    this->Known.MeanError += error - (this->Known.MeanError >> 7);
    return bit;
  }

  static std::uint32_t Hash(std::uint32_t low, std::uint32_t high)
  {
    const std::uint32_t key = (low * 0x9E3779B1u ^ high) * 0x85EBCA6Bu;
    return (key ^ key >> 15) >> 3 & ((1u << 14) - 1);
  }

  Indices FindIndices(const SignNetworkInputs& seen, int predicted) const
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

  // The difference of a context's probability from the network's prediction, both stretched, times
  // n / (n + 3/2) after n updates.
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

  NetworkSignModel& Known;
  const SignNetwork& Network;
  SignNeighborhood Around;
  alignas(32) SignNetwork::Sums Sums; ///< of the row
};

} // namespace isosurface

#endif
