// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignNetwork_h
#define isosurface_SignNetwork_h

#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * The signs around a vertex, of which the network predicts its own. Each told from the sign of the
 * vertex to the left: 1 is another one. Windows of a row are lowest bit first; rows are named as in
 * SignRowsAround.
 */
struct SignNetworkInputs
{
  /// The patterns in their order; how many bits each has.
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
  static constexpr std::array<int, NumberOfPatterns> Bits = { 7, 7, 7, 7, 7, 7, 7, 5, 5, 5, 5, 5, 6,
    6 };

  std::array<std::uint8_t, NumberOfPatterns> Patterns{};
};

/// What of a row the network looks at: whether the slice is the first, the second, and whether the
/// row is the first, the second, the last.
using SignNetworkRow = std::array<bool, 5>;

/// Weights as they are learnt; see Documentation/formats/edge-index.md. Part of the format.
struct SignNetworkWeights
{
  static constexpr std::size_t NumberOfInputs = 91; ///< of all patterns, and five of the row
  static constexpr std::size_t Width = 64;
  static constexpr std::size_t Depth = 16;

  std::array<std::array<std::int16_t, Width>, NumberOfInputs + 1> First; ///< last: what is added
  std::array<std::array<std::int16_t, Width>, Depth> Second;
  std::array<std::int32_t, Depth> SecondAdded;
  std::array<std::int16_t, Depth> Third;
  std::int32_t ThirdAdded;
};
extern const SignNetworkWeights LearntSignNetwork;

/**
 * A neural network that predicts the sign of a vertex from some 90 decoded ones: two hidden layers,
 * rectified and bounded. All in integers. Inputs are bits, so the sums of the first layer are
 * looked up, a pattern of bits at a time (after Y. Nasu, "Efficiently updatable
 * neural-network-based evaluation functions for computer shogi", 2018; here nothing is updated).
 */
class SignNetwork
{
public:
  static constexpr std::size_t Width = SignNetworkWeights::Width;
  static constexpr std::size_t Depth = SignNetworkWeights::Depth;
  /// Hidden values are at most that, 8 in units of 2^-8.
  static constexpr int Greatest = 2047;

  explicit SignNetwork(const SignNetworkWeights& weights);

  /// What a row begins with.
  using Sums = std::array<std::int16_t, Width>;
  Sums MakeRow(const SignNetworkRow& row) const;

  /// The stretched probability (-2047 .. 2047, see Squash) that the vertex has another sign than
  /// the one to its left; `hidden` becomes the second hidden layer.
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
      inner = inner < 0 ? 0 : inner > Greatest ? Greatest : inner;
      hidden[n] = static_cast<std::int16_t>(inner);
      sum += inner * this->Weights.Third[n];
    }
    sum >>= 10;
    return sum < -Greatest ? -Greatest : sum > Greatest ? Greatest : sum;
  }

private:
  void AddPatterns(const Sums& row, const SignNetworkInputs& inputs, Sums& first) const
  {
    const Sums* looked[SignNetworkInputs::NumberOfPatterns];
    for (std::size_t n = 0; n < SignNetworkInputs::NumberOfPatterns; ++n)
    {
      looked[n] = &this->Table[this->Begins[n] + inputs.Patterns[n]];
    }
    static_assert(SignNetworkInputs::NumberOfPatterns == 14, "all patterns are added");
    for (std::size_t i = 0; i < Width; ++i)
    {
      const int sum = row[i] + (*looked[0])[i] + (*looked[1])[i] + (*looked[2])[i] +
        (*looked[3])[i] + (*looked[4])[i] + (*looked[5])[i] + (*looked[6])[i] + (*looked[7])[i] +
        (*looked[8])[i] + (*looked[9])[i] + (*looked[10])[i] + (*looked[11])[i] + (*looked[12])[i] +
        (*looked[13])[i];
      const auto narrow = static_cast<std::int16_t>(sum);
      first[i] = narrow < 0 ? std::int16_t{ 0 }
        : narrow > Greatest ? std::int16_t{ Greatest }
                            : narrow;
    }
  }

  static constexpr std::size_t NumberOfEntries = 7 * 128 + 5 * 32 + 2 * 64;

  SignNetworkWeights Weights;
  std::array<std::size_t, SignNetworkInputs::NumberOfPatterns> Begins;
  alignas(32) std::array<Sums, NumberOfEntries> Table; ///< the sum for each pattern
};

/// The network of the format; made once.
const SignNetwork& GetSignNetwork();

} // namespace isosurface

#endif
