// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueCoder_h
#define isosurface_ValueCoder_h

#include "Coding/BlockCoding/RelevantVertices.h"
#include "Coding/BlockCoding/ResidualCoder.h"
#include "Coding/BlockCoding/ValueDomain.h"
#include "Coding/Prediction/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace isosurface
{

/// What is learnt about the values of a block.
struct ValueModel
{
  static constexpr int NumberOfTaps = 16;
  /// The filter's inputs stand in an order in which few loads fetch them: input n is number
  /// InputOrder[n] of the format.
  static constexpr std::array<std::size_t, NumberOfTaps> InputOrder = { 3, 1, 4, 12, 5, 2, 6, 13, 0,
    11, 7, 9, 10, 8, 14, 15 };

  explicit ValueModel(bool isUsed);

  /// Forgets what was learnt since it was like `fresh`.
  void Reset(const ValueModel& fresh);

  ResidualModel Residuals;
  alignas(64) std::array<std::int32_t, NumberOfTaps> Weights; ///< in units of 2^-25, by InputOrder
  std::int32_t MeanHeight = 700 << 6; ///< the mean magnitude of heights that were coded, times 64
  int MeanLevel = 24 * 16;            ///< of coded magnitudes (MeasureMagnitude), times 16
};

/// What is known around the vertex whose value is predicted.
struct ValueSurroundings
{
  static constexpr std::ptrdiff_t RowStride = 80; ///< of heights

  /// Heights of the row at x = 0: in this slice, the one before, and the one before that.
  std::array<std::int16_t*, 3> Rows{};
  const SignSlice* Signs = nullptr; ///< of this slice
  const SignSlice* Above = nullptr; ///< of the next slice; of this one if it is the last

  bool Inside = false;      ///< the vertex
  unsigned Crossed = 0;     ///< bits of the crossed edges that begin at it: x, y, z
  std::int32_t Typical = 0; ///< the mean magnitude of heights

  /// A typical height on the side of the vertex.
  std::int32_t GetSide() const { return this->Inside ? this->Typical : -this->Typical; }
  /// An input of predictions: the more crossed edges begin at the vertex, the further on the other
  /// side.
  std::int32_t GetLeading() const
  {
    return -__builtin_popcount(this->Crossed) * this->GetSide() * 3 / 10;
  }
};

/**
 * Predicts a height from 14 decoded ones, and the signs, by a linear filter that learns from each
 * value (normalised least mean squares: B. Widrow and M. E. Hoff, "Adaptive switching circuits",
 * 1960; J. Nagumo and A. Noda, 1967).
 */
class ValueFilter
{
public:
  explicit ValueFilter(ValueModel& model)
    : Model(model)
  {
  }

  void BeginSlice()
  {
    const std::int64_t mean = std::max(this->Model.MeanHeight >> 6, 8);
    const std::int64_t power = mean * mean * 3 / 2;
    // 16777: a learning rate of 0.0005 in the unit of weights, 2^-25.
    this->Rate = static_cast<std::int32_t>((std::int64_t(16777) << 16) / power);
  }

  void BeginRow()
  {
    // What they learn in one row is too little to overflow from these bounds.
    constexpr std::int32_t maximum = 1 << 27;
    for (std::int32_t& weight : this->Model.Weights)
    {
      weight = std::clamp(weight, -maximum, maximum);
    }
    this->ShortenWeights();
  }

  std::int32_t Predict(const ValueSurroundings& around, int x)
  {
    const std::int16_t* p = around.Rows[0] + x;
    const std::int16_t* z = around.Rows[1] + x;
    const std::int16_t second = around.Rows[2][x];
    const std::int32_t side = around.GetSide();
    const std::int32_t leading = around.GetLeading();
    constexpr std::ptrdiff_t row = ValueSurroundings::RowStride;
#if defined(__SSE2__)
    // Assembled in registers: one load of what several stores just wrote would stall. The heights
    // before on the row are loaded one by one for the same reason, the last one at last.
    const auto four = [](const std::int16_t* first, std::int16_t last)
    { return _mm_insert_epi16(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(first)), last, 3); };
    const auto two = [](const std::int16_t* first)
    { return _mm_cvtsi32_si128(Load<std::int32_t>(first)); };
    __m128i rest = _mm_slli_si128(_mm_unpacklo_epi32(two(z - row), two(z + row - 1)), 4);
    rest = _mm_insert_epi16(_mm_insert_epi16(rest, side, 6), leading, 7);
    rest = _mm_insert_epi16(_mm_insert_epi16(rest, p[-2], 1), p[-1], 0);
    const __m128i halves[2] = {
      _mm_unpacklo_epi64(four(p - row - 1, p[-2 * row]), four(z - 1, second)), rest
    };
    __m128i sums = _mm_setzero_si128();
    for (int half = 0; half < 2; ++half)
    {
      _mm_store_si128(reinterpret_cast<__m128i*>(this->Inputs.data()) + half, halves[half]);
      const __m128i weights =
        _mm_load_si128(reinterpret_cast<const __m128i*>(this->ShortWeights.data()) + half);
      sums = _mm_add_epi32(sums, _mm_madd_epi16(halves[half], weights));
    }
    const __m128i pairs = _mm_add_epi32(sums, _mm_shuffle_epi32(sums, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xb1))) >> 13;
#else
    this->Inputs = { p[-row - 1], p[-row], p[-row + 1], p[-2 * row], z[-1], z[0], z[1], second,
      p[-1], p[-2], z[-row], z[-row + 1], z[row - 1], z[row], static_cast<std::int16_t>(side),
      static_cast<std::int16_t>(leading) };
    std::int32_t sum = 0;
    for (std::size_t n = 0; n < Taps; ++n)
    {
      sum += this->Inputs[n] * this->ShortWeights[n];
    }
    return sum >> 13;
#endif
  }

  /// Learns the height at the vertex that was predicted last.
  void Learn(std::int32_t predicted, std::int32_t height)
  {
    const std::int64_t error = std::clamp(height - predicted, -8191, 8191);
    const auto step =
      static_cast<std::int32_t>(std::clamp<std::int64_t>(error * this->Rate >> 8, -32767, 32767));
    this->Adapt(static_cast<std::int16_t>(step));
  }

private:
  static constexpr std::size_t Taps = ValueModel::NumberOfTaps;
  static constexpr int ShortShift = 12; ///< from Weights to ShortWeights

  template <typename Word>
  static Word Load(const std::int16_t* values)
  {
    Word word;
    std::memcpy(&word, values, sizeof(word));
    return word;
  }

  // Moves weights by inputs * step.
  void Adapt(std::int16_t step)
  {
#if defined(__SSE2__)
    const __m128i factor = _mm_set1_epi16(step);
    auto* weights = reinterpret_cast<__m128i*>(this->Model.Weights.data());
    for (int half = 0; half < 2; ++half)
    {
      const __m128i inputs =
        _mm_load_si128(reinterpret_cast<const __m128i*>(this->Inputs.data()) + half);
      const __m128i low = _mm_mullo_epi16(inputs, factor);
      const __m128i high = _mm_mulhi_epi16(inputs, factor);
      const auto move = [](__m128i& weight, __m128i product)
      {
        weight = _mm_add_epi32(weight, _mm_srai_epi32(product, 8));
        return _mm_srai_epi32(weight, ShortShift);
      };
      const __m128i first = move(weights[2 * half], _mm_unpacklo_epi16(low, high));
      const __m128i second = move(weights[2 * half + 1], _mm_unpackhi_epi16(low, high));
      _mm_store_si128(reinterpret_cast<__m128i*>(this->ShortWeights.data()) + half,
        _mm_packs_epi32(first, second));
    }
#else
    for (std::size_t n = 0; n < Taps; ++n)
    {
      this->Model.Weights[n] += this->Inputs[n] * step >> 8;
    }
    this->ShortenWeights();
#endif
  }

  void ShortenWeights()
  {
    for (std::size_t n = 0; n < Taps; ++n)
    {
      this->ShortWeights[n] =
        static_cast<std::int16_t>(std::clamp(this->Model.Weights[n] >> ShortShift, -32768, 32767));
    }
  }

  ValueModel& Model;
  std::int32_t Rate = 0; ///< of learning, over the mean square of inputs; in units of 2^-41
  alignas(32) std::array<std::int16_t, Taps> Inputs{};
  alignas(32) std::array<std::int16_t, Taps> ShortWeights{}; ///< those that predict
};

/**
 * Codes values at the relevant vertices of a block, slice after slice, each in the order of rows.
 *
 * A value is predicted from the heights of decoded neighbours by ValueFilter; the difference is coded.
 * Vertices that are not relevant have no value. Instead they get a predicted height, if they are near
 * relevant ones, or a typical one on their side of the isovalue. Used by the profile small.
 */
template <typename Coder>
class ValueCoder
{
public:
  ValueCoder(Coder& coder, ValueModel& model, const ValueDomain& domain, int sizeX, int sizeY)
    : Model(model)
    , Domain(domain)
    , Output(coder)
    , Residuals(coder, model.Residuals)
    , SizeX(sizeX)
    , SizeY(sizeY)
    , Filter(model)
  {
    for (auto& plane : this->Heights)
    {
      plane.fill(0);
    }
    this->Levels.fill(static_cast<std::uint16_t>(model.MeanLevel / 16));
  }
  ValueCoder(const ValueCoder&) = delete;
  ValueCoder& operator=(const ValueCoder&) = delete;

  /// Begins the next slice. below, above: the slices beside it, null at the ends of the block.
  void BeginSlice(const SignSlice& signs, const SignSlice* below, const SignSlice* above)
  {
    FindRelevant(signs, below, above, this->SizeX, this->SizeY, true, this->Vertices);
    this->Around.Signs = &signs;
    this->Around.Above = above ? above : &signs;
    this->Below = below;
    this->IsLast = !above;
    std::rotate(this->Planes.begin(), this->Planes.begin() + 2, this->Planes.end());
    this->FillHeights();
    this->Filter.BeginSlice();
  }
  const RelevantSlice& GetRelevant() const { return this->Vertices; }

  /// Codes the values at the relevant vertices of row y: codes[x], given or set.
  void CodeRow(int y, std::int64_t* codes)
  {
    const auto row = static_cast<std::size_t>(y);
    const SignRow& relevant = this->Vertices.Relevant[row];
    const SignRow& visited = this->Vertices.Near[row];
    if (visited.IsZero())
    {
      return;
    }
    this->BeginRow(y);
    Coder coder = this->Output;
    VisitBits(visited,
      [&](int x)
      {
        if (relevant.Get(x))
        {
          this->CodeVertex(coder, x, codes[x]);
        }
        else
        {
          this->FillVertex(x);
        }
      });
    this->Output = coder;
  }

private:
  static constexpr std::ptrdiff_t RowStride = ValueSurroundings::RowStride;
  static constexpr std::ptrdiff_t FirstVertex = 2 * RowStride + 8;
  using Plane = std::array<std::int16_t, (MaximumCodedVertices + 4) * RowStride>;

  // Sets all heights to a typical one on the side of the vertex.
  void FillHeights()
  {
    const auto typical = static_cast<std::int16_t>(
      std::min(3 * (this->Model.MeanHeight >> 6) / 2, ValueDomain::MaximumHeight));
    Plane& plane = this->Heights[this->Planes[0]];
    for (int y = -2; y < this->SizeY + 2; ++y)
    {
      const SignRow& row = this->Around.Signs->At(y);
      // From vertex -8 on, that is from bit 8.
      const std::uint64_t bits[2] = { row.Words[0] >> 8 | row.Words[1] << 56, row.Words[1] >> 8 };
      std::int16_t* heights = plane.data() + (y + 2) * RowStride;
      for (int n = 0; n < RowStride; n += 8)
      {
        FillEight(static_cast<std::uint32_t>(bits[n / 64] >> (n % 64) & 255), typical, heights + n);
      }
    }
  }

  static void FillEight(std::uint32_t inside, std::int16_t height, std::int16_t* heights)
  {
#if defined(__SSE2__)
    const __m128i places = _mm_set_epi16(128, 64, 32, 16, 8, 4, 2, 1);
    const __m128i bits = _mm_and_si128(_mm_set1_epi16(static_cast<std::int16_t>(inside)), places);
    const __m128i outside = _mm_cmpeq_epi16(bits, _mm_setzero_si128());
    const __m128i positive = _mm_set1_epi16(height);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(heights),
      _mm_sub_epi16(_mm_xor_si128(positive, outside), outside));
#else
    for (int n = 0; n < 8; ++n)
    {
      heights[n] = (inside >> n & 1) != 0 ? height : static_cast<std::int16_t>(-height);
    }
#endif
  }

  void BeginRow(int y)
  {
    const std::ptrdiff_t offset = FirstVertex + y * RowStride;
    for (std::size_t n = 0; n < 3; ++n)
    {
      this->Around.Rows[n] = this->Heights[this->Planes[n]].data() + offset;
    }
    this->LevelRow = this->Levels.data() + (y + 1) * RowStride + 8;
    const SignSlice& signs = *this->Around.Signs;
    const SignRow& own = signs.At(y);
    const SignRow none;
    this->Forward[0] = own ^ own.ShiftDown();
    this->Forward[1] = y + 1 < this->SizeY ? own ^ signs.At(y + 1) : none;
    this->Forward[2] = this->IsLast ? none : own ^ this->Around.Above->At(y);
    this->Backward[0] = own ^ own.ShiftUp();
    this->Backward[1] = y > 0 ? own ^ signs.At(y - 1) : none;
    this->Backward[2] = this->Below ? own ^ this->Below->At(y) : none;
    this->Own = own;
    this->Filter.BeginRow();
  }

  static unsigned CollectBits(const std::array<SignRow, 3>& edges, int x)
  {
    unsigned bits = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bits |= (edges[axis].Get(x) ? 1u : 0u) << axis;
    }
    return bits;
  }

  std::int32_t Predict(int x)
  {
    this->Around.Inside = this->Own.Get(x);
    this->Around.Crossed = CollectBits(this->Forward, x);
    this->Around.Typical = this->Model.MeanHeight >> 6;
    return this->Filter.Predict(this->Around, x);
  }

  // Gives a vertex without a value its predicted height.
  void FillVertex(int x)
  {
    const std::int32_t typical = this->Model.MeanHeight >> 6;
    const std::int32_t height = this->Predict(x);
    const std::int32_t minimum = 3 * typical / 10;
    const std::int32_t maximum = std::min(6 * typical, ValueDomain::MaximumHeight);
    this->Around.Rows[0][x] =
      static_cast<std::int16_t>(this->Around.Inside ? std::clamp(height, minimum, maximum)
                                                    : std::clamp(height, -maximum, -minimum));
  }

  void CodeVertex(Coder& coder, int x, std::int64_t& code)
  {
    const std::int32_t height = this->Predict(x);
    ResidualContext context;
    context.Level = FindExpectedLevel(this->LevelRow + x, RowStride);
    const std::uint64_t magnitude = this->Domain.GetKind() == ValueDomain::Kind::Offsets
      ? this->CodeOffset(coder, x, height, context, code)
      : this->CodeBits(coder, x, height, context, code);
    const int level = MeasureMagnitude(magnitude);
    this->LevelRow[x] = static_cast<std::uint16_t>(level);
    this->Model.MeanLevel += level - this->Model.MeanLevel / 16;
    this->Learn(x, height, this->Domain.ToHeight(code));
  }

  // Codes by their distance from the predicted code, within the bounds of the vertex's side.
  std::uint64_t CodeOffset(
    Coder& coder, int x, std::int32_t height, ResidualContext& context, std::int64_t& code)
  {
    int quarter = 0;
    const std::int64_t middle = this->Domain.FromHeight(height, quarter);
    BoundedGuess guess{};
    guess.Minimum = this->Domain.GetMinimum(this->Around.Inside);
    guess.Maximum = this->Domain.GetMaximum(this->Around.Inside);
    guess.Guess = std::clamp(middle, guess.Minimum, guess.Maximum);
    guess.LowerFirst = quarter < 2;
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      magnitude = guess.ToMagnitude(code);
    }
    this->FindSides(x, height, 2 * static_cast<std::uint64_t>(guess.GetRoom()), quarter, context);
    magnitude = this->Residuals.Code(coder, magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      code = guess.FromMagnitude(magnitude);
    }
    return magnitude;
  }

  // Codes by their difference from the predicted code, modulo 2^32 or 2^64.
  std::uint64_t CodeBits(
    Coder& coder, int x, std::int32_t height, ResidualContext& context, std::int64_t& code)
  {
    int quarter = 0;
    const auto guess = static_cast<std::uint64_t>(this->Domain.FromHeight(height, quarter));
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      magnitude = MakeMagnitude(this->Domain.Wrap(static_cast<std::uint64_t>(code) - guess));
    }
    this->FindSides(x, height, ~std::uint64_t(0), 0, context);
    magnitude = this->Residuals.Code(coder, magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      code = this->Domain.Wrap(guess + MakeDifference(magnitude));
    }
    return magnitude;
  }

  // room: how many numbers lie on both sides of the guess.
  void FindSides(
    int x, std::int32_t height, std::uint64_t room, int quarter, ResidualContext& context) const
  {
    // The room up to the isovalue, compared with what is needed.
    const int spare = std::clamp((MeasureMagnitude(room) - context.Level + 12) / 6, 0, 7);
    context.Sides[0] = static_cast<std::uint32_t>(spare);
    const std::uint32_t inside = this->Around.Inside ? 64 : 0;
    context.Sides[0] |= static_cast<std::uint32_t>(quarter) << 3 | inside;
    this->FindFurtherSides(x, height, inside, context);
  }

  // inside: a bit of all sides.
  void FindFurtherSides(
    int x, std::int32_t height, std::uint32_t inside, ResidualContext& context) const
  {
    const unsigned crossed = this->Around.Crossed;
    context.Sides[1] = crossed | CollectBits(this->Backward, x) << 3 | inside;
    const std::uint16_t* level = this->LevelRow + x;
    const auto compare = [&context](int other)
    { return static_cast<std::uint32_t>(std::clamp((other - context.Level + 12) >> 3, 0, 3)); };
    context.Sides[2] =
      compare(level[-1]) | compare(level[-RowStride]) << 2 | compare(level[0]) << 4 | inside;
    const std::int16_t* p = this->Around.Rows[0] + x;
    const std::int16_t* z = this->Around.Rows[1] + x;
    const int slope = std::abs(p[-1] - z[-1]) + std::abs(p[-RowStride] - z[-RowStride]);
    const int steep = MeasureMagnitude(static_cast<std::uint64_t>(slope)) -
      MeasureMagnitude(static_cast<std::uint64_t>(this->Model.MeanHeight >> 6));
    context.Sides[3] = static_cast<std::uint32_t>(std::clamp((steep + 36) / 6, 0, 15)) |
      static_cast<std::uint32_t>(__builtin_popcount(crossed)) << 4 | inside;
    const int unit = std::max(this->Model.MeanHeight >> 8, 1);
    const auto place = [unit, height](int other)
    { return static_cast<std::uint32_t>(std::clamp((other - height) / unit + 2, 0, 3)); };
    context.Sides[4] = place(p[-1]) | place(p[-RowStride]) << 2 | place(z[0]) << 4 | inside;
  }

  void Learn(int x, std::int32_t predicted, std::int32_t height)
  {
    this->Around.Rows[0][x] = static_cast<std::int16_t>(height);
    this->Model.MeanHeight += ((std::abs(height) << 6) - this->Model.MeanHeight) >> 10;
    this->Filter.Learn(predicted, height);
  }

  ValueModel& Model;
  const ValueDomain& Domain;
  Coder& Output;
  ResidualCoder<Coder, true> Residuals;
  int SizeX;
  int SizeY;

  std::array<Plane, 3> Heights;
  /// Which of Heights belongs to this slice, the one before, and the one before that.
  std::array<std::size_t, 3> Planes{ 0, 1, 2 };
  /// The level of the magnitude that was coded last at each place of a slice.
  std::array<std::uint16_t, (MaximumCodedVertices + 2) * RowStride> Levels;
  RelevantSlice Vertices;
  const SignSlice* Below = nullptr;
  bool IsLast = false;

  // Of the row.
  std::uint16_t* LevelRow = nullptr;
  SignRow Own;
  std::array<SignRow, 3> Forward;  ///< crossed edges that begin at vertices
  std::array<SignRow, 3> Backward; ///< crossed edges that end at vertices

  ValueSurroundings Around;
  ValueFilter Filter;
};

} // namespace isosurface

#endif
