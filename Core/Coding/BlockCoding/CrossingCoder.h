// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingCoder_h
#define isosurface_CrossingCoder_h

#include "Coding/BlockCoding/CrossingIntervals.h"
#include "Coding/BlockCoding/ResidualCoder.h"
#include "Coding/Prediction/CrossingFit.h"
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
  explicit CrossingModel(bool mixed);

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
 * CrossingFit predicts by a plane if `Mixed`, else by the mean of parallel edges.
 */
template <typename Coder, bool Mixed>
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
    for (ErrorLevels& levels : this->Levels)
    {
      std::fill_n(levels.begin(), used, static_cast<std::uint16_t>(model.MeanLevel / 16));
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
  static constexpr std::ptrdiff_t RowStride = CrossingFit::RowStride;

  using ErrorLevels = std::array<std::uint16_t, CrossingPlaneSize>;

  struct Prediction
  {
    std::int32_t Position = 0; ///< 0 to CrossingFit::FineUnit, as the other positions
    int Steepness = 0;         ///< see CrossingFit::Result
    int Number = 0;            ///< likewise
    int Level = 0;             ///< MeasureMagnitude of the expected error in eighths of an interval
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
    const CrossingFit::Result fit = Mixed
      ? this->Fit.Predict(axis, x, y, at, inside, this->Slices, this->Planes)
      : this->Fit.PredictParallel(axis, x, y, at, this->Planes);
    // The expected error follows from the errors around.
    return { fit.Position, fit.Steepness, fit.Number,
      FindExpectedLevel(this->Levels[static_cast<std::size_t>(axis)].data() + at, RowStride) };
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
  }

  // Remembers the error of a prediction.
  void Learn(int axis, std::ptrdiff_t at, const Prediction& prediction, std::uint32_t bin)
  {
    const std::int64_t error =
      8 * std::int64_t{ bin } + 4 - (this->Intervals.Locate(prediction.Position) >> 13);
    const int level = MeasureMagnitude(static_cast<std::uint64_t>(error < 0 ? -error : error));
    this->Levels[static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)] =
      static_cast<std::uint16_t>(level);
    this->Model.MeanLevel += level - this->Model.MeanLevel / 16;
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
  std::array<const SignSlice*, 3> Slices{}; ///< before, this one, after
  std::array<std::array<CrossingPlane, 3>, 3> Memory;
  CrossingPlanes Planes{};           ///< [this slice, the one before, the next one][axis]
  std::array<ErrorLevels, 3> Levels; ///< of the errors of predictions, by axis
};

} // namespace isosurface

#endif
