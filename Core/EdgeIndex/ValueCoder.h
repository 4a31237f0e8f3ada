// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueCoder_h
#define isosurface_ValueCoder_h

#include "EdgeIndex/HeightFit.h"
#include "EdgeIndex/ResidualCoder.h"
#include "EdgeIndex/SignRows.h"
#include "EdgeIndex/ValueDomain.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace isosurface
{

/// The vertices of a slice that lie on a crossed edge, and those close to one.
struct RelevantSlice
{
  std::array<SignRow, MaximumCodedVertices> Relevant;
  std::array<SignRow, MaximumCodedVertices> Near;
  bool IsEmpty = true; ///< no vertex is relevant
};

/**
 * Finds the relevant vertices of a slice. below, above: its neighbours, null at the block's ends.
 * `near` asks for RelevantSlice::Near.
 */
void FindRelevant(const SignSlice& slice, const SignSlice* below, const SignSlice* above, int sizeX,
  int sizeY, bool near, RelevantSlice& relevant);

/// What is known about values.
struct ValueModel
{
  static constexpr int NumberOfTaps = 16;
  /// The inputs of the filter stand in an order in which they can be loaded at once: at n the one
  /// that the format has at InputOrder[n].
  static constexpr std::array<std::size_t, NumberOfTaps> InputOrder = { 3, 1, 4, 12, 5, 2, 6, 13, 0,
    11, 7, 9, 10, 8, 14, 15 };

  explicit ValueModel(bool mixed);

  ResidualModel Residuals;
  alignas(64) std::array<std::int32_t, NumberOfTaps> Weights; ///< in units of 2^-25, by InputOrder
  std::int32_t MeanHeight;                                    ///< of relevant ones, times 64
  int MeanLevel;                                              ///< of magnitudes, times 16
};

/**
 * Codes values at the relevant vertices of a block, slice after slice, each in the order of rows.
 *
 * A value is predicted from the heights of 14 decoded neighbours and the signs around it by a
 * filter that learns (normalised least mean squares: B. Widrow and M. E. Hoff, "Adaptive switching
 * circuits", 1960; J. Nagumo and A. Noda 1967). Vertices that are not relevant have no value; they
 * get a prediction, or a typical height, on their side of the isovalue instead. Fitted (which is
 * for mixed ones): by HeightFit, from more inputs, in place of the filter.
 */
template <typename Coder, bool Mixed, bool Fitted>
class ValueCoder
{
public:
  ValueCoder(Coder& coder, ValueModel& model, const ValueDomain& domain, int sizeX, int sizeY)
    : Model(model)
    , Domain(domain)
    , Residuals(coder, model.Residuals)
    , SizeX(sizeX)
    , SizeY(sizeY)
  {
    for (auto& plane : this->Heights)
    {
      plane.fill(0);
    }
    this->Levels.fill(static_cast<std::uint16_t>(model.MeanLevel / 16));
    static_assert(Mixed || !Fitted, "what is fitted looks at vertices nearby");
  }

  /// Goes on to the next slice. `above` is null for the last one.
  void BeginSlice(const SignSlice& signs, const SignSlice* below, const SignSlice* above)
  {
    FindRelevant(signs, below, above, this->SizeX, this->SizeY, Mixed, this->Vertices);
    this->Signs = &signs;
    this->Below = below;
    this->Above = above;
    std::rotate(this->Planes.begin(), this->Planes.begin() + 2, this->Planes.end());
    this->FillHeights();
    this->UpdateRates();
  }
  const RelevantSlice& GetRelevant() const { return this->Vertices; }

  /// Codes the values at the relevant vertices of row y: codes[x], given or set.
  void CodeRow(int y, std::int64_t* codes)
  {
    const auto row = static_cast<std::size_t>(y);
    const SignRow& relevant = this->Vertices.Relevant[row];
    if constexpr (Mixed)
    {
      const SignRow& near = this->Vertices.Near[row];
      if (!near.IsZero())
      {
        this->BeginRow(y);
        VisitBits(near,
          [&](int x)
          {
            if (relevant.Get(x))
            {
              this->CodeVertex(x, codes[x]);
            }
            else
            {
              this->FillVertex(x);
            }
          });
      }
    }
    else if (!relevant.IsZero())
    {
      this->BeginRow(y);
      VisitBits(relevant, [&](int x) { this->CodeVertex(x, codes[x]); });
    }
  }

private:
  static constexpr int Taps = ValueModel::NumberOfTaps;
  static constexpr int ShortShift = 12; ///< from weights to those that predict
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::ptrdiff_t FirstVertex = 2 * RowStride + 8;
  using Plane = std::array<std::int16_t, (MaximumCodedVertices + 4) * RowStride>;

  // Vertices start with a typical height on their side.
  void FillHeights()
  {
    const auto typical =
      static_cast<std::int16_t>(std::min(3 * (this->Model.MeanHeight >> 6) / 2, 4095));
    Plane& plane = this->Heights[this->Planes[0]];
    for (int y = -2; y < this->SizeY + 2; ++y)
    {
      const SignRow& row = this->Signs->At(y);
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

  void UpdateRates()
  {
    const std::int64_t mean = std::max(this->Model.MeanHeight >> 6, 8);
    const std::int64_t power = mean * mean * 3 / 2;
    this->Rate = static_cast<std::int32_t>((std::int64_t(16777) << 16) / power);
  }

  void BeginRow(int y)
  {
    this->Y = y;
    const std::ptrdiff_t offset = FirstVertex + y * RowStride;
    for (std::size_t n = 0; n < 3; ++n)
    {
      this->Rows[n] = this->Heights[this->Planes[n]].data() + offset;
    }
    this->LevelRow = this->Levels.data() + (y + 1) * RowStride + 8;
    const SignRow& own = this->Signs->At(y);
    const SignRow none;
    this->Forward[0] = own ^ own.ShiftDown();
    this->Forward[1] = y + 1 < this->SizeY ? own ^ this->Signs->At(y + 1) : none;
    this->Forward[2] = this->Above ? own ^ this->Above->At(y) : none;
    this->Backward[0] = own ^ own.ShiftUp();
    this->Backward[1] = y > 0 ? own ^ this->Signs->At(y - 1) : none;
    this->Backward[2] = this->Below ? own ^ this->Below->At(y) : none;
    this->Own = own;
    // A row cannot make them overflow.
    constexpr std::int32_t most = 1 << 27;
    for (std::int32_t& weight : this->Model.Weights)
    {
      weight = std::clamp(weight, -most, most);
    }
    this->ShortenWeights();
  }

  // Returns the predicted height; fills the inputs that it is learnt from.
  std::int32_t Predict(int x)
  {
    this->Inside = this->Own.Get(x);
    this->Crossed = 0;
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Crossed |= (this->Forward[axis].Get(x) ? 1u : 0u) << axis;
    }
    const int typical = this->Model.MeanHeight >> 6;
    const int crossed = __builtin_popcount(this->Crossed);
    const int side = this->Inside ? typical : -typical;
    const std::int32_t leading = -crossed * side * 3 / 10;
    if constexpr (Fitted)
    {
      return this->PredictByFit(x, side, leading);
    }
    else
    {
      return this->PredictByFilter(x, side, leading);
    }
  }

  std::int32_t PredictByFit(int x, int side, std::int32_t leading)
  {
    const std::int16_t* p = this->Rows[0] + x;
    const std::int16_t* z = this->Rows[1] + x;
    constexpr std::ptrdiff_t row = RowStride;
    const auto typical = static_cast<std::int16_t>(this->Model.MeanHeight >> 6);
    const auto getSide = [x, typical](const SignRow& signs)
    { return signs.Get(x + 1) ? typical : static_cast<std::int16_t>(-typical); };
    const auto getOther = [this, side](unsigned axis)
    { return static_cast<std::int16_t>((this->Crossed >> axis & 1) != 0 ? -side : side); };
    const SignSlice& next = this->Above ? *this->Above : *this->Signs;
    const std::array<std::int16_t, HeightFit::NumberOfInputs> inputs = { p[-1], p[-row], z[0],
      p[-row - 1], p[-row + 1], z[-1], z[1], z[-row], z[row], z[-row + 1], z[row - 1], p[-2],
      p[-2 * row], this->Rows[2][x], static_cast<std::int16_t>(side),
      static_cast<std::int16_t>(leading), z[-row - 1], z[row + 1], getOther(0), getOther(1),
      getOther(2), getSide(this->Signs->At(this->Y + 1)), getSide(next.At(this->Y)),
      next.At(this->Y + 1).Get(x) ? typical : static_cast<std::int16_t>(-typical) };
    std::copy(inputs.begin(), inputs.end(), this->Fit.GetInputs());
    return this->Fit.Predict();
  }

  std::int32_t PredictByFilter(int x, int side, std::int32_t leading)
  {
    const std::int16_t* p = this->Rows[0] + x;
    const std::int16_t* z = this->Rows[1] + x;
    constexpr std::ptrdiff_t row = RowStride;
#if defined(__SSE2__)
    // Put together in registers: a load of what was just stored in pieces would have to wait. The
    // values before on the row are loaded one by one for the same reason.
    const auto lane = [](std::int32_t value, int n)
    { return std::uint64_t{ static_cast<std::uint16_t>(value) } << (16 * n); };
    constexpr std::uint64_t three = (std::uint64_t{ 1 } << 48) - 1;
    const std::uint64_t fours[4] = { (Load<std::uint64_t>(p - row - 1) & three) |
        lane(p[-2 * row], 3),
      (Load<std::uint64_t>(z - 1) & three) | lane(this->Rows[2][x], 3),
      lane(p[-1], 0) | lane(p[-2], 1) | std::uint64_t{ Load<std::uint32_t>(z - row) } << 32,
      Load<std::uint32_t>(z + row - 1) | lane(side, 2) | lane(leading, 3) };
    __m128i sums = _mm_setzero_si128();
    for (int half = 0; half < 2; ++half)
    {
      const __m128i inputs = _mm_set_epi64x(
        static_cast<long long>(fours[2 * half + 1]), static_cast<long long>(fours[2 * half]));
      _mm_store_si128(reinterpret_cast<__m128i*>(this->Inputs.data()) + half, inputs);
      const __m128i weights =
        _mm_load_si128(reinterpret_cast<const __m128i*>(this->ShortWeights.data()) + half);
      sums = _mm_add_epi32(sums, _mm_madd_epi16(inputs, weights));
    }
    const __m128i pairs = _mm_add_epi32(sums, _mm_shuffle_epi32(sums, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xb1))) >> 13;
#else
    this->Inputs = { p[-row - 1], p[-row], p[-row + 1], p[-2 * row], z[-1], z[0], z[1],
      this->Rows[2][x], p[-1], p[-2], z[-row], z[-row + 1], z[row - 1], z[row],
      static_cast<std::int16_t>(side), static_cast<std::int16_t>(leading) };
    std::int32_t sum = 0;
    for (std::size_t n = 0; n < Taps; ++n)
    {
      sum += this->Inputs[n] * this->ShortWeights[n];
    }
    return sum >> 13;
#endif
  }

  template <typename Word>
  static Word Load(const std::int16_t* values)
  {
    Word word;
    std::memcpy(&word, values, sizeof(word));
    return word;
  }

  void FillVertex(int x)
  {
    const std::int32_t typical = this->Model.MeanHeight >> 6;
    const std::int32_t height = this->Predict(x);
    const std::int32_t least = 3 * typical / 10;
    const std::int32_t most = std::min(6 * typical, ValueDomain::MostHeight);
    this->Rows[0][x] = static_cast<std::int16_t>(
      this->Inside ? std::clamp(height, least, most) : std::clamp(height, -most, -least));
  }

  void CodeVertex(int x, std::int64_t& code)
  {
    const std::int32_t height = this->Predict(x);
    const std::uint16_t* level = this->LevelRow + x;
    ResidualContext context;
    context.Level = (4 * (level[-1] + level[-RowStride] + level[0]) +
                      2 * (level[-RowStride - 1] + level[-RowStride + 1]) + 8) >>
      4;
    int magnitude = 0;
    if (this->Domain.GetKind() == ValueDomain::Kind::Offsets)
    {
      magnitude = this->CodeOffset(x, height, context, code);
    }
    else
    {
      magnitude = this->CodeBits(x, height, context, code);
    }
    this->LevelRow[x] = static_cast<std::uint16_t>(magnitude);
    this->Model.MeanLevel += magnitude - this->Model.MeanLevel / 16;
    this->Learn(x, height, this->Domain.ToHeight(code));
  }

  // The predicted code and the side on which the next nearest one lies; the magnitude counts codes
  // by their distance from the prediction, on both sides as long as the range allows.
  int CodeOffset(int x, std::int32_t height, ResidualContext& context, std::int64_t& code)
  {
    const std::int64_t least = this->Domain.GetLeast(this->Inside);
    const std::int64_t greatest = this->Domain.GetGreatest(this->Inside);
    int quarter = 0;
    const std::int64_t guess = this->Domain.FromHeight(height, quarter);
    const std::int64_t middle = std::clamp(guess, least, greatest);
    const bool lowerFirst = quarter < 2;
    const std::int64_t room = std::min(middle - least, greatest - middle);
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      const std::int64_t difference = code - middle;
      const std::int64_t distance = difference < 0 ? -difference : difference;
      const bool first = (difference < 0) == lowerFirst;
      magnitude = static_cast<std::uint64_t>(distance > room ? distance + room
          : first && distance != 0                           ? 2 * distance - 1
                                                             : 2 * distance);
    }
    this->FindSides(x, height, 2 * static_cast<std::uint64_t>(room), quarter, context);
    magnitude = this->Residuals.Code(magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      const auto limit = static_cast<std::uint64_t>(greatest - least);
      const auto number = static_cast<std::int64_t>(std::min(magnitude, limit));
      if (number > 2 * room)
      {
        code =
          middle - least > greatest - middle ? middle - (number - room) : middle + (number - room);
      }
      else
      {
        const std::int64_t distance = (number + 1) / 2;
        code = ((number & 1) != 0) == lowerFirst ? middle - distance : middle + distance;
      }
    }
    return MeasureMagnitude(magnitude);
  }

  // Differences of bits, modulo their number, with the sign in the lowest bit.
  int CodeBits(int x, std::int32_t height, ResidualContext& context, std::int64_t& code)
  {
    int quarter = 0;
    const auto guess = static_cast<std::uint64_t>(this->Domain.FromHeight(height, quarter));
    const bool narrow = this->Domain.GetWidth() == 32;
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      const std::uint64_t difference = static_cast<std::uint64_t>(code) - guess;
      const std::int64_t e = narrow
        ? static_cast<std::int32_t>(static_cast<std::uint32_t>(difference))
        : static_cast<std::int64_t>(difference);
      magnitude = (static_cast<std::uint64_t>(e) << 1) ^ static_cast<std::uint64_t>(e >> 63);
    }
    this->FindSides(x, height, ~std::uint64_t(0), 0, context);
    magnitude = this->Residuals.Code(magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      const std::uint64_t sum = guess + ((magnitude >> 1) ^ (0 - (magnitude & 1)));
      code = narrow ? static_cast<std::int32_t>(static_cast<std::uint32_t>(sum))
                    : static_cast<std::int64_t>(sum);
    }
    return MeasureMagnitude(magnitude);
  }

  void FindSides(
    int x, std::int32_t height, std::uint64_t room, int quarter, ResidualContext& context) const
  {
    // How much of the range there is to the isovalue, against what is needed.
    const int spare = std::clamp((MeasureMagnitude(room) - context.Level + 12) / 6, 0, 7);
    context.Sides[0] = static_cast<std::uint32_t>(spare);
    if constexpr (Mixed)
    {
      context.Sides[0] |= static_cast<std::uint32_t>(quarter) << 3;
      std::uint32_t back = 0;
      for (int axis = 0; axis < 3; ++axis)
      {
        back |= (this->Backward[axis].Get(x) ? 1u : 0u) << axis;
      }
      context.Sides[1] = this->Crossed | back << 3;
      const std::uint16_t* level = this->LevelRow + x;
      const auto compare = [&context](int other)
      { return static_cast<std::uint32_t>(std::clamp((other - context.Level + 12) >> 3, 0, 3)); };
      context.Sides[2] =
        compare(level[-1]) | compare(level[-RowStride]) << 2 | compare(level[0]) << 4;
      const std::int16_t* p = this->Rows[0] + x;
      const std::int16_t* z = this->Rows[1] + x;
      const int slope = std::abs(p[-1] - z[-1]) + std::abs(p[-RowStride] - z[-RowStride]);
      const int steep = MeasureMagnitude(static_cast<std::uint64_t>(slope)) -
        MeasureMagnitude(static_cast<std::uint64_t>(this->Model.MeanHeight >> 6));
      context.Sides[3] = static_cast<std::uint32_t>(std::clamp((steep + 36) / 6, 0, 15)) |
        static_cast<std::uint32_t>(__builtin_popcount(this->Crossed)) << 4;
      const int unit = std::max(this->Model.MeanHeight >> 8, 1);
      const auto place = [unit, height](int other)
      { return static_cast<std::uint32_t>(std::clamp((other - height) / unit + 2, 0, 3)); };
      context.Sides[4] = place(p[-1]) | place(p[-RowStride]) << 2 | place(z[0]) << 4;
      for (std::uint32_t& side : context.Sides)
      {
        side |= this->Inside ? 64 : 0;
      }
    }
  }

  void Learn(int x, std::int32_t predicted, std::int32_t height)
  {
    this->Rows[0][x] = static_cast<std::int16_t>(height);
    this->Model.MeanHeight += ((std::abs(height) << 6) - this->Model.MeanHeight) >> 10;
    if constexpr (Fitted)
    {
      // A height at the bound says little about those around.
      if (std::abs(height) < ValueDomain::MostHeight)
      {
        this->Fit.Learn(height);
      }
      return;
    }
    const std::int64_t error = std::clamp(height - predicted, -8191, 8191);
    const auto step =
      static_cast<std::int32_t>(std::clamp<std::int64_t>(error * this->Rate >> 8, -32767, 32767));
    this->Adapt(static_cast<std::int16_t>(step));
  }

  // Weights move by inputs * step; those that predict are kept as well.
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

  // The weights that the filter begins with, as those of the fit.
  static std::array<std::int32_t, HeightFit::NumberOfInputs> MakeFirstWeights(
    const ValueModel& model)
  {
    std::array<std::int32_t, HeightFit::NumberOfInputs> weights{};
    for (std::size_t n = 0; n < Taps; ++n)
    {
      weights[ValueModel::InputOrder[n]] = model.Weights[n] >> (25 - LinearFit<1>::WeightBits);
    }
    return weights;
  }

  ValueModel& Model;
  const ValueDomain& Domain;
  ResidualCoder<Coder, Mixed> Residuals;
  int SizeX;
  int SizeY;

  std::array<Plane, 3> Heights;
  std::array<std::size_t, 3> Planes{ 0, 1,
    2 }; ///< of this slice, the one before, the one before it
  /// The magnitude that came last at each place of a slice.
  std::array<std::uint16_t, (MaximumCodedVertices + 2) * RowStride> Levels;
  RelevantSlice Vertices;
  const SignSlice* Signs = nullptr;
  const SignSlice* Below = nullptr;
  const SignSlice* Above = nullptr;

  // Of the row, then of the vertex.
  int Y = 0;
  std::int32_t Rate = 0;
  std::array<std::int16_t*, 3> Rows{};
  std::uint16_t* LevelRow = nullptr;
  SignRow Own;
  std::array<SignRow, 3> Forward;
  std::array<SignRow, 3> Backward;
  alignas(32) std::array<std::int16_t, Taps> Inputs{};
  alignas(32) std::array<std::int16_t, Taps> ShortWeights{};
  HeightFit Fit{ MakeFirstWeights(this->Model) }; ///< only if fitted
  bool Inside = false;
  unsigned Crossed = 0; ///< the edges from the vertex along x, y, z that are
};

} // namespace isosurface

#endif
