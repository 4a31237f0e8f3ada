// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignNetwork_h
#define isosurface_SignNetwork_h

#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// The signs around a vertex, from which the network predicts its sign. A bit is 1 where the sign
/// differs from that of the vertex to the left. Windows of a row have x - n in the lowest bit; rows
/// are named as in SignRowsAround (BlockCoding/SignCoder.h).
struct SignNetworkInputs
{
  /// The patterns in the order of the format.
  enum Pattern : std::uint8_t
  {
    Own, ///< at x - 4, x - 3, x - 2 of the row; the sign at x - 1 itself; whether x is 0, 1, last
    Y,   ///< x - 3 .. x + 3, as the five that follow
    YY,
    Z,
    ZM,
    ZP,
    ZZ,
    YYY, ///< x - 2 .. x + 2, as the four that follow
    ZMM,
    ZPP,
    ZZM,
    ZZP,
    ZMMMPPP, ///< x - 1 .. x + 1 of the rows y - 3 and y + 3 of the slice before
    ZZMMPP,  ///< the same of the rows y - 2 and y + 2 of the slice before that
    NumberOfPatterns
  };
  /// How many bits each pattern has.
  static constexpr std::array<int, NumberOfPatterns> Bits = { 7, 7, 7, 7, 7, 7, 7, 5, 5, 5, 5, 5, 6,
    6 };

  std::array<std::uint8_t, NumberOfPatterns> Patterns{};
};

/// Inputs that a whole row shares: whether the slice is the first, the second; whether the row is
/// the first, the second, the last.
using SignNetworkRow = std::array<bool, 5>;

/// Weights of the network, part of the format; see Documentation/formats/edge-index.md.
struct SignNetworkWeights
{
  static constexpr std::size_t NumberOfInputs = 91; ///< bits of all patterns, and five of the row
  static constexpr std::size_t Width = 64;
  static constexpr std::size_t Depth = 16;

  std::array<std::array<std::int16_t, Width>, NumberOfInputs + 1>
    First; ///< the last row is always added
  std::array<std::array<std::int16_t, Width>, Depth> Second;
  std::array<std::int32_t, Depth> SecondAdded;
  std::array<std::int16_t, Depth> Third;
  std::int32_t ThirdAdded;
};
/// The weights of sign-network.txt.
const SignNetworkWeights& GetTrainedWeights();

/**
 * A neural network that predicts the sign of a vertex from some 90 decoded signs: two hidden layers,
 * rectified and clamped, in integers throughout. Inputs are bits, so the sums of the first layer are
 * looked up, one pattern of bits at a time. After: Y. Nasu, "Efficiently updatable
 * neural-network-based evaluation functions for computer shogi", 2018 (here nothing is updated).
 */
class SignNetwork
{
public:
  static constexpr std::size_t Width = SignNetworkWeights::Width;
  static constexpr std::size_t Depth = SignNetworkWeights::Depth;
  /// The maximum of hidden values: 8, in units of 2^-8.
  static constexpr int Maximum = 2047;

  explicit SignNetwork(const SignNetworkWeights& weights);

  /// Sums of the first layer.
  using Sums = std::array<std::int16_t, Width>;
  /// The part of the sums that a row shares.
  Sums MakeRow(const SignNetworkRow& row) const;

  /// The stretched probability (-2047 .. 2047, see isosurface::Squash) that the vertex's sign
  /// differs from that of the vertex to its left. `hidden` becomes the second hidden layer.
  int Predict(
    const Sums& row, const SignNetworkInputs& inputs, std::array<std::int16_t, Depth>& hidden) const
  {
    alignas(32) std::array<std::int16_t, Width> first;
    this->AddPatterns(row, inputs, first);
    int sum = this->Weights.ThirdAdded;
    for (std::size_t n = 0; n < Depth; ++n)
    {
      int inner = 0;
      for (std::size_t i = 0; i < Width; ++i)
      {
        inner += first[i] * this->Weights.Second[n][i];
      }
      inner = (inner + this->Weights.SecondAdded[n]) >> 10;
      inner = inner < 0 ? 0 : inner > Maximum ? Maximum : inner;
      hidden[n] = static_cast<std::int16_t>(inner);
      sum += inner * this->Weights.Third[n];
    }
    sum >>= 10;
    return sum < -Maximum ? -Maximum : sum > Maximum ? Maximum : sum;
  }

private:
  void AddPatterns(const Sums& row, const SignNetworkInputs& inputs, Sums& first) const
  {
    const Sums* found[SignNetworkInputs::NumberOfPatterns];
    for (std::size_t n = 0; n < SignNetworkInputs::NumberOfPatterns; ++n)
    {
      found[n] = &this->Table[this->Begins[n] + inputs.Patterns[n]];
    }
    static_assert(SignNetworkInputs::NumberOfPatterns == 14, "all patterns are added");
    for (std::size_t i = 0; i < Width; ++i)
    {
      const int sum = row[i] + (*found[0])[i] + (*found[1])[i] + (*found[2])[i] + (*found[3])[i] +
        (*found[4])[i] + (*found[5])[i] + (*found[6])[i] + (*found[7])[i] + (*found[8])[i] +
        (*found[9])[i] + (*found[10])[i] + (*found[11])[i] + (*found[12])[i] + (*found[13])[i];
      const auto narrow = static_cast<std::int16_t>(sum);
      first[i] = narrow < 0 ? std::int16_t{ 0 }
        : narrow > Maximum  ? std::int16_t{ Maximum }
                            : narrow;
    }
  }

  static constexpr std::size_t NumberOfEntries = 7 * 128 + 5 * 32 + 2 * 64;

  SignNetworkWeights Weights;
  std::array<std::size_t, SignNetworkInputs::NumberOfPatterns> Begins;
  alignas(32) std::array<Sums, NumberOfEntries> Table; ///< the sums of each value of each pattern
};

/// The network with the weights of the format; made once.
const SignNetwork& GetSignNetwork();

} // namespace isosurface

#endif
