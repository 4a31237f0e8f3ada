// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ValueCoder_h
#define isosurface_ValueCoder_h

#include "EdgeIndex/ResidualCoder.h"
#include "EdgeIndex/SignRows.h"
#include "EdgeIndex/ValueDomain.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

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

  explicit ValueModel(bool mixed);

  ResidualModel Residuals;
  alignas(64) std::array<std::int32_t, NumberOfTaps> Weights; ///< in units of 2^-25
  std::int32_t MeanHeight;                                    ///< of relevant ones, times 64
  int MeanLevel;                                              ///< of magnitudes, times 16
};

/**
 * Codes values at the relevant vertices of a block, slice after slice, each in the order of rows.
 *
 * A value is predicted from the heights of 14 decoded neighbours and the signs around it by a
 * filter that learns (normalised least mean squares: B. Widrow and M. E. Hoff, "Adaptive switching
 * circuits", 1960; J. Nagumo and A. Noda 1967). Vertices that are not relevant have no value; they
 * get a prediction, or a typical height, on their side of the isovalue instead.
 */
template <typename Coder, bool Mixed>
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
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::ptrdiff_t FirstVertex = 2 * RowStride + 8;
  using Plane = std::array<std::int16_t, (MaximumCodedVertices + 4) * RowStride>;

  // Vertices start with a typical height on their side.
  void FillHeights()
  {
    const int typical = std::min(3 * (this->Model.MeanHeight >> 6) / 2, 4095);
    const auto inside = static_cast<std::int16_t>(typical);
    const auto outside = static_cast<std::int16_t>(-typical);
    Plane& plane = this->Heights[this->Planes[0]];
    for (int y = -2; y < this->SizeY + 2; ++y)
    {
      const SignRow& row = this->Signs->At(y);
      // From vertex -8 on, that is from bit 8.
      const std::uint64_t bits[2] = { row.Words[0] >> 8 | row.Words[1] << 56, row.Words[1] >> 8 };
      std::int16_t* heights = plane.data() + (y + 2) * RowStride;
      for (int n = 0; n < RowStride; ++n)
      {
        heights[n] = (bits[n / 64] >> (n % 64) & 1) != 0 ? inside : outside;
      }
    }
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
    for (std::size_t n = 0; n < Taps; ++n)
    {
      this->ShortWeights[n] =
        static_cast<std::int16_t>(std::clamp(this->Model.Weights[n] >> 12, -32767, 32767));
    }
  }

  // Fills Inputs; returns the predicted height.
  std::int32_t Predict(int x)
  {
    const std::int16_t* p = this->Rows[0] + x;
    const std::int16_t* z = this->Rows[1] + x;
    constexpr std::ptrdiff_t row = RowStride;
    this->Inside = this->Own.Get(x);
    this->Crossed = 0;
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Crossed |= (this->Forward[axis].Get(x) ? 1u : 0u) << axis;
    }
    const int typical = this->Model.MeanHeight >> 6;
    const int crossed = __builtin_popcount(this->Crossed);
    const int side = this->Inside ? typical : -typical;
    std::int16_t* in = this->Inputs.data();
    in[0] = p[-1];
    in[1] = p[-row];
    in[2] = z[0];
    in[3] = p[-row - 1];
    in[4] = p[-row + 1];
    in[5] = z[-1];
    in[6] = z[1];
    in[7] = z[-row];
    in[8] = z[row];
    in[9] = z[-row + 1];
    in[10] = z[row - 1];
    in[11] = p[-2];
    in[12] = p[-2 * row];
    in[13] = this->Rows[2][x];
    in[14] = static_cast<std::int16_t>(side);
    in[15] = static_cast<std::int16_t>(-crossed * side * 3 / 10);
    std::int32_t sum = 0;
    for (std::size_t n = 0; n < Taps; ++n)
    {
      sum += this->Inputs[n] * this->ShortWeights[n];
    }
    return sum >> 13;
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
    const std::int64_t error = std::clamp(height - predicted, -8191, 8191);
    const auto step =
      static_cast<std::int32_t>(std::clamp<std::int64_t>(error * this->Rate >> 8, -32767, 32767));
    constexpr std::int32_t most = 1 << 27;
    for (std::size_t n = 0; n < Taps; ++n)
    {
      const std::int32_t weight = this->Model.Weights[n] + (this->Inputs[n] * step >> 8);
      this->Model.Weights[n] = weight < -most ? -most : weight > most ? most : weight;
      const std::int32_t rounded = this->Model.Weights[n] >> 12;
      this->ShortWeights[n] = static_cast<std::int16_t>(rounded < -32767 ? -32767
          : rounded > 32767                                              ? 32767
                                                                         : rounded);
    }
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
  bool Inside = false;
  unsigned Crossed = 0; ///< the edges from the vertex along x, y, z that are
};

} // namespace isosurface

#endif
