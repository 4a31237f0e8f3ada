// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingCoder_h
#define isosurface_CrossingCoder_h

#include "Coding/BlockCoding/CrossingIntervals.h"
#include "Coding/BlockCoding/EdgeIndexProfile.h"
#include "Coding/BlockCoding/ResidualCoder.h"
#include "Coding/Prediction/CrossingCycles.h"
#include "Coding/Prediction/CrossingFit.h"
#include "Coding/Prediction/CurvedFit.h"
#include "Coding/Prediction/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace isosurface
{

/// What is learnt about the crossings of a block.
struct CrossingModel
{
  explicit CrossingModel(EdgeIndexProfile profile);

  /// Forgets what was learnt since it was like `fresh`.
  void Reset(const CrossingModel& fresh);

  ResidualModel Residuals;
  AdaptiveBit Missing;
  int MeanLevel = 20 * 16; ///< of errors in eighths of an interval, times 16
};

/**
 * Codes where the surface crosses the edges of a block, slice after slice: the rows of a slice, for
 * each row the edges along x, y, then z (to the next slice). An edge is cut into intervals; the
 * interval of the crossing is predicted from decoded crossings nearby, of edges in all directions.
 * The profile default predicts by a plane (CrossingFit), compact by a mixture of a plane and a
 * quadratic surface (CurvedFit) and by cycles of crossed edges (CrossingCycles).
 */
template <typename Coder, EdgeIndexProfile Profile>
class CrossingCoder
{
public:
  CrossingCoder(Coder& coder, CrossingModel& model, const CrossingIntervals& intervals,
    bool missing, int sizeX, int sizeY)
    : Output(coder)
    , Model(model)
    , Residuals(coder, model.Residuals)
    , Intervals(intervals)
    , LastBin(static_cast<std::int32_t>(intervals.GetCount()) - 1)
    , HasMissing(missing)
    , SizeX(sizeX)
    , SizeY(sizeY)
  {
    // Further rows are never read; most of a small block's planes are not needed.
    const std::ptrdiff_t used = (sizeY + 4) * RowStride;
    for (std::size_t n = 0; n < 3; ++n)
    {
      this->Planes[n] = &this->Memory[n];
      for (CrossingPlane& plane : this->Memory[n])
      {
        std::fill_n(plane.Positions.begin(), used, CrossingFit::None);
      }
    }
    for (std::size_t n = 0; n < (Curved ? 3 : 1); ++n)
    {
      for (ErrorLevels& levels : this->Levels[n])
      {
        std::fill_n(levels.begin(), used, static_cast<std::uint16_t>(model.MeanLevel / 16));
      }
    }
  }

  CrossingCoder(const CrossingCoder&) = delete;
  CrossingCoder& operator=(const CrossingCoder&) = delete;

  /// Begins the next slice. below, above: the slices beside it, null at the ends of the block.
  void BeginSlice(const SignSlice& signs, const SignSlice* below, const SignSlice* above)
  {
    std::swap(this->Planes[0], this->Planes[1]);
    this->Slices = { below ? below : &signs, &signs, above ? above : &signs };
    this->IsLast = !above;
    this->MarkCrossings(signs, above, *this->Planes[0]);
    if (Mixed && above)
    {
      this->MarkCrossings(*above, nullptr, *this->Planes[2]);
    }
    else if (Mixed)
    {
      for (CrossingPlane& plane : *this->Planes[2])
      {
        plane.Crossed.fill(SignRow());
      }
    }
  }

  /// The crossed edges along an axis that begin at the vertices of row y.
  SignRow FindEdges(int axis, int y) const
  {
    return this->FindCrossed(axis, y, *this->Slices[1], this->IsLast ? nullptr : this->Slices[2]);
  }

  /// Codes the intervals of these edges: bins[x], given or set. The number of intervals stands for
  /// a crossing that is not a number.
  void CodeRow(int axis, int y, const SignRow& edges, std::uint32_t* bins)
  {
    VisitBits(edges, [&](int x) { this->CodeEdge(axis, x, y, bins[x]); });
  }

private:
  static constexpr bool Mixed = IsMixed(Profile);
  static constexpr bool Curved = Profile == EdgeIndexProfile::Compact;
  static constexpr std::ptrdiff_t RowStride = CrossingFit::RowStride;

  // The share of the quadratic fit is a logistic function (Squash) of the sum of: a constant, the
  // difference of the fits' expected levels, and their mean difference in the block; factors of
  // these.
  static constexpr int BlendBegin = 30;
  static constexpr int BlendAround = 40;
  static constexpr int BlendMean = 90;

  using ErrorLevels = std::array<std::uint16_t, CrossingPlaneSize>;

  struct Prediction
  {
    std::int32_t Position = 0; ///< 0 to CrossingFit::FineUnit, as the other positions
    int Steepness = 0;         ///< see CrossingFit::Result
    int Number = 0;            ///< likewise
    int Level = 0;             ///< MeasureMagnitude of the expected error in eighths of an interval
    // Only if curved:
    bool IsClosed = false;      ///< cycles lead to the edge
    std::int32_t Fitted = 0;    ///< Position before cycles changed it
    std::int32_t Linear = 0;    ///< of the linear fit
    std::int32_t Quadratic = 0; ///< of the quadratic fit
  };

  SignRow FindCrossed(int axis, int y, const SignSlice& slice, const SignSlice* above) const
  {
    return FindCrossedEdges(axis, y, slice, above, this->SizeX, this->SizeY);
  }

  // Marks the crossed edges of a slice, whose crossings are not decoded yet.
  void MarkCrossings(
    const SignSlice& slice, const SignSlice* above, std::array<CrossingPlane, 3>& planes) const
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      CrossingPlane& plane = planes[static_cast<std::size_t>(axis)];
      for (int y = 0; y < this->SizeY; ++y)
      {
        const SignRow crossed = this->FindCrossed(axis, y, slice, above);
        plane.Crossed[static_cast<std::size_t>(y + 2)] = crossed;
        std::int16_t* row = plane.Positions.data() + (y + 2) * RowStride + CrossingFit::RowMargin;
        VisitBits(crossed, [row](int x) { row[x] = CrossingFit::Later; });
      }
    }
  }

  void CodeEdge(int axis, int x, int y, std::uint32_t& bin)
  {
    const std::ptrdiff_t at = (y + 2) * RowStride + x + CrossingFit::RowMargin;
    std::int16_t& position =
      (*this->Planes[0])[static_cast<std::size_t>(axis)].Positions[static_cast<std::size_t>(at)];
    if (this->HasMissing && this->CodeMissing(bin))
    {
      position = CrossingFit::None;
      return;
    }
    const Prediction prediction = this->Predict(axis, x, y, at);
    this->CodeBin(axis, prediction, bin);
    this->Learn(axis, at, prediction, bin);
    position = this->Intervals.GetPosition(bin);
  }

  // Codes whether the crossing is not a number.
  bool CodeMissing(std::uint32_t& bin)
  {
    const auto missing = static_cast<std::uint32_t>(this->LastBin) + 1;
    const bool isMissing = CodeAdaptive(this->Output, this->Model.Missing, bin == missing, 255);
    bin = isMissing ? missing : bin;
    return isMissing;
  }

  Prediction Predict(int axis, int x, int y, std::ptrdiff_t at) const
  {
    const bool inside = this->Slices[1]->At(y).Get(x);
    if constexpr (Curved)
    {
      return this->PredictCurved(axis, x, y, at, inside);
    }
    else
    {
      const CrossingFit::Result fit = Mixed
        ? this->Fit.Predict(axis, x, y, at, inside, this->Slices, this->Planes)
        : this->Fit.PredictParallel(axis, x, y, at, this->Planes);
      Prediction prediction;
      prediction.Position = fit.Position;
      prediction.Steepness = fit.Steepness;
      prediction.Number = fit.Number;
      prediction.Level = this->FindLevel(0, axis, at);
      return prediction;
    }
  }

  void CodeBin(int axis, const Prediction& prediction, std::uint32_t& bin)
  {
    // In units of 2^-16 intervals.
    const std::int64_t position = this->Intervals.Locate(prediction.Position);
    BoundedGuess guess{};
    guess.Maximum = this->LastBin;
    guess.Guess = std::min(position >> 16, guess.Maximum);
    const auto quarter =
      static_cast<int>(std::min<std::int64_t>((position - (guess.Guess << 16)) >> 14, 3));
    guess.LowerFirst = quarter < 2;

    ResidualContext context;
    context.Level = std::max(prediction.Level - 16, 0);
    this->FindSides(axis, guess, quarter, prediction, context);
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      magnitude = guess.ToMagnitude(bin);
    }
    magnitude = this->Residuals.Code(magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      bin = static_cast<std::uint32_t>(guess.FromMagnitude(magnitude));
    }
  }

  // The expected error of a prediction, from the errors around.
  int FindLevel(std::size_t of, int axis, std::ptrdiff_t at) const
  {
    return FindExpectedLevel(
      this->Levels[of][static_cast<std::size_t>(axis)].data() + at, RowStride);
  }

  // The linear and the quadratic fit, mixed by their errors nearby and in the whole block, and
  // cycles.
  Prediction PredictCurved(int axis, int x, int y, std::ptrdiff_t at, bool inside) const
  {
    const CurvedFit::Result fit =
      CurvedFit::Get().Predict(axis, x, y, at, inside, this->Slices, this->Planes);
    const int better = BlendBegin +
      BlendAround * (this->FindLevel(1, axis, at) - this->FindLevel(2, axis, at)) +
      (BlendMean * this->MeanDifference >> 8);
    const auto share = static_cast<std::int64_t>(
      Tables.Squash[static_cast<std::size_t>(std::clamp(better, -2047, 2047) + 2048)]);
    Prediction prediction;
    prediction.Linear = fit.Linear;
    prediction.Quadratic = fit.Quadratic;
    prediction.Fitted =
      fit.Linear + static_cast<std::int32_t>((fit.Quadratic - fit.Linear) * share >> 16);
    prediction.Position = prediction.Fitted;
    prediction.Steepness = fit.Steepness;
    prediction.Number = fit.Number;
    prediction.Level = this->FindLevel(0, axis, at);
    this->CloseCycles(axis, x, y, at, prediction);
    return prediction;
  }

  // Improves the prediction where cycles lead to the edge. Cycles and fits count by the inverse of
  // their variances; that of the fits follows from the level.
  void CloseCycles(int axis, int x, int y, std::ptrdiff_t at, Prediction& prediction) const
  {
    const CrossingCycles::Result cycles =
      CrossingCycles::Get().Predict(axis, x, y, at, this->Planes);
    if (cycles.Weight == 0)
    {
      return;
    }
    const int octaves = std::min(prediction.Level / 4, 30);
    const std::int64_t variance =
      61 + (128 + 32 * (prediction.Level % 4)) * (std::int64_t{ 1 } << octaves);
    const std::int64_t weight = std::max<std::int64_t>((std::int64_t{ 1 } << 30) / variance, 1);
    const std::int64_t other = cycles.Weight << 6;
    prediction.Position = static_cast<std::int32_t>(
      (prediction.Position * weight + cycles.Position * other) / (weight + other));
    const int gain = MeasureMagnitude(static_cast<std::uint64_t>(weight + other)) -
      MeasureMagnitude(static_cast<std::uint64_t>(weight));
    prediction.Level = std::max(prediction.Level - gain / 2, 0);
    prediction.IsClosed = true;
  }

  void FindSides(int axis, const BoundedGuess& guess, int quarter, const Prediction& prediction,
    ResidualContext& context) const
  {
    const auto room = 2 * static_cast<std::uint64_t>(guess.GetRoom());
    const int spare = std::clamp((MeasureMagnitude(room) - context.Level + 12) / 6, 0, 7);
    context.Sides[0] = static_cast<std::uint32_t>(spare);
    if constexpr (Mixed)
    {
      const auto fine = static_cast<std::uint32_t>(std::clamp(prediction.Level / 3, 0, 15));
      const auto steep = static_cast<std::uint32_t>(prediction.Steepness);
      const auto side = static_cast<std::uint32_t>(quarter);
      const auto sixteenth = static_cast<std::uint32_t>(std::min(prediction.Position >> 12, 15));
      context.Sides[0] |= side << 3;
      context.Sides[1] = fine | side << 4;
      context.Sides[2] = steep | static_cast<std::uint32_t>(axis) << 3;
      context.Sides[3] = sixteenth | side << 4;
      context.Sides[4] = steep | static_cast<std::uint32_t>(std::min(prediction.Number, 7)) << 3;
    }
    if constexpr (Curved)
    {
      const std::int64_t above = guess.Maximum - guess.Guess;
      context.Sides[0] |= static_cast<std::uint32_t>(std::min<std::int64_t>(above, 3)) << 5;
      context.Sides[4] |= prediction.IsClosed ? 64 : 0;
    }
  }

  void Learn(int axis, std::ptrdiff_t at, const Prediction& prediction, std::uint32_t bin)
  {
    if constexpr (Curved)
    {
      this->SetLevel(0, axis, at, bin, prediction.Fitted);
      const int linear = this->SetLevel(1, axis, at, bin, prediction.Linear);
      const int quadratic = this->SetLevel(2, axis, at, bin, prediction.Quadratic);
      this->MeanDifference += (256 * (linear - quadratic) - this->MeanDifference) / 128;
    }
    else
    {
      this->SetLevel(0, axis, at, bin, prediction.Position);
    }
    const int level = this->Levels[0][static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)];
    this->Model.MeanLevel += level - this->Model.MeanLevel / 16;
  }

  // Remembers the error of a prediction; returns its level.
  int SetLevel(
    std::size_t of, int axis, std::ptrdiff_t at, std::uint32_t bin, std::int32_t predicted)
  {
    const std::int64_t error =
      8 * std::int64_t{ bin } + 4 - (this->Intervals.Locate(predicted) >> 13);
    const int level = MeasureMagnitude(static_cast<std::uint64_t>(error < 0 ? -error : error));
    this->Levels[of][static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)] =
      static_cast<std::uint16_t>(level);
    return level;
  }

  Coder& Output;
  CrossingModel& Model;
  ResidualCoder<Coder, Mixed> Residuals;
  const CrossingFit& Fit = CrossingFit::Get();
  CrossingIntervals Intervals;
  std::int32_t LastBin; ///< the last interval of an edge
  bool HasMissing;
  int SizeX;
  int SizeY;
  bool IsLast = false;
  int MeanDifference =
    2 << 8; ///< level of the linear fit minus that of the quadratic one, times 256
  std::array<const SignSlice*, 3> Slices{}; ///< before, this one, after
  std::array<std::array<CrossingPlane, 3>, 3> Memory;
  CrossingPlanes Planes{}; ///< [this slice, the one before, the next one][axis]
  /// Levels of errors: of the prediction; if curved, also of the linear and of the quadratic fit.
  /// [which][axis]
  std::array<std::array<ErrorLevels, 3>, Curved ? 3 : 1> Levels;
};

} // namespace isosurface

#endif
