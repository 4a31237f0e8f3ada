// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingCoder_h
#define isosurface_CrossingCoder_h

#include "EdgeIndex/BlockScheme.h"
#include "EdgeIndex/CrossingCycles.h"
#include "EdgeIndex/CrossingFit.h"
#include "EdgeIndex/CrossingIntervals.h"
#include "EdgeIndex/CurvedFit.h"
#include "EdgeIndex/ResidualCoder.h"
#include "EdgeIndex/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace isosurface
{

/// What is known about crossings.
struct CrossingModel
{
  explicit CrossingModel(BlockScheme scheme)
    : Residuals(IsCurved(scheme) ? ResidualModel(CurvedCrossingPriors)
                                 : ResidualModel(IsMixed(scheme), Priors.Crossings))
  {
  }
  ResidualModel Residuals;
  AdaptiveBit Missing;
  int MeanLevel = 20 * 16; ///< of errors in eighths of an interval, times 16
};

/**
 * Codes where on the crossed edges of a block the surface is, slice after slice: the rows of a
 * slice, of each row the edges along x, y, then z (to the next slice). An edge is cut into
 * intervals; the interval is predicted by a plane fitted to the decoded crossings of all three
 * directions nearby (see CrossingFit); if curved, which is mixed as well, by a quadratic surface
 * (CurvedFit), and by cycles of crossed edges (CrossingCycles).
 */
template <typename Coder, bool Mixed, bool Curved>
class CrossingCoder
{
public:
  CrossingCoder(Coder& coder, CrossingModel& model, const CrossingIntervals& intervals,
    bool missing, int sizeX, int sizeY)
    : Output(coder)
    , Model(model)
    , Residuals(coder, model.Residuals)
    , Intervals(intervals)
    , Bins(intervals.GetCount())
    , HasMissing(missing)
    , SizeX(sizeX)
    , SizeY(sizeY)
  {
    // Rows behind those of the block and its margins are not looked at; blocks may be small.
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

  /// Goes on to the next slice. `above` is null for the last one.
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

  /// Codes the intervals of those edges: bins[x], given or set; the number of bins stands for a
  /// crossing that is not a number.
  void CodeRow(int axis, int y, const SignRow& edges, std::uint32_t* bins)
  {
    VisitBits(edges, [&](int x) { this->CodeEdge(axis, x, y, bins[x]); });
  }

private:
  static constexpr std::ptrdiff_t RowStride = CrossingFit::RowStride;

  // What a difference of levels counts for the quadratic fit, in units of 1/256 of the logarithm.
  static constexpr int BlendBegin = 30;
  static constexpr int BlendAround = 40;
  static constexpr int BlendMean = 90;

  using ErrorLevels = std::array<std::uint16_t, CrossingPlaneSize>;

  struct Prediction
  {
    std::int32_t Position = 0;  ///< 0 to CrossingFit::FineUnit, as the others
    int Steepness = 0;          ///< see CrossingFit::Result
    int Number = 0;             ///< likewise
    int Level = 0;              ///< of the error to expect
    bool IsClosed = false;      ///< by cycles
    std::int32_t Fitted = 0;    ///< what it was before those
    std::int32_t Linear = 0;    ///< by the linear fit
    std::int32_t Quadratic = 0; ///< by the quadratic one
  };

  SignRow FindCrossed(int axis, int y, const SignSlice& slice, const SignSlice* above) const
  {
    return FindCrossedEdges(axis, y, slice, above, this->SizeX, this->SizeY);
  }

  // Tells for each edge of a slice whether there will be a crossing.
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
    if (this->HasMissing)
    {
      const bool missing = CodeAdaptive(this->Output, this->Model.Missing, bin == this->Bins, 255);
      if (missing)
      {
        bin = this->Bins;
        (*this->Planes[0])[static_cast<std::size_t>(axis)].Positions[static_cast<std::size_t>(at)] =
          CrossingFit::None;
        return;
      }
    }
    const bool inside = this->Slices[1]->At(y).Get(x);
    Prediction prediction;
    if constexpr (Curved)
    {
      prediction = this->PredictCurved(axis, x, y, at, inside);
    }
    else
    {
      const CrossingFit::Result fit = Mixed
        ? this->Fit.Predict(axis, x, y, at, inside, this->Slices, this->Planes)
        : this->Fit.PredictParallel(axis, x, y, at, this->Planes);
      prediction = { fit.Position, fit.Steepness, fit.Number, this->FindLevel(0, axis, at) };
    }
    const int level = prediction.Level;
    // In units of 2^-16 intervals.
    const std::int64_t position = this->Intervals.Locate(prediction.Position);
    const auto middle = static_cast<std::int32_t>(
      std::min<std::int64_t>(position >> 16, std::int64_t{ this->Bins } - 1));
    const int quarter = static_cast<int>(
      std::min<std::int64_t>((position - (std::int64_t{ middle } << 16)) >> 14, 3));
    const bool lowerFirst = quarter < 2;
    const auto last = static_cast<std::int32_t>(this->Bins) - 1;
    const std::int32_t room = std::min(middle, last - middle);

    ResidualContext context;
    context.Level = std::max(level - 16, 0);
    this->FindSides(axis, room, quarter, prediction, context);
    if constexpr (Curved)
    {
      context.Sides[0] |= static_cast<std::uint32_t>(std::min(last - middle, 3)) << 5;
      context.Sides[4] |= prediction.IsClosed ? 64 : 0;
    }

    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      const std::int32_t difference = static_cast<std::int32_t>(bin) - middle;
      const std::int32_t distance = difference < 0 ? -difference : difference;
      const bool first = (difference < 0) == lowerFirst;
      magnitude = static_cast<std::uint64_t>(distance > room ? distance + room
          : first && distance != 0                           ? 2 * distance - 1
                                                             : 2 * distance);
    }
    magnitude = this->Residuals.Code(magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      const auto number =
        static_cast<std::int32_t>(std::min(magnitude, static_cast<std::uint64_t>(last)));
      std::int32_t decoded = 0;
      if (number > 2 * room)
      {
        decoded = middle > last - middle ? middle - (number - room) : middle + (number - room);
      }
      else
      {
        const std::int32_t distance = (number + 1) / 2;
        decoded = ((number & 1) != 0) == lowerFirst ? middle - distance : middle + distance;
      }
      bin = static_cast<std::uint32_t>(decoded);
    }
    if constexpr (Curved)
    {
      this->Learn(0, axis, at, bin, prediction.Fitted);
      this->Learn(1, axis, at, bin, prediction.Linear);
      this->Learn(2, axis, at, bin, prediction.Quadratic);
      this->LearnDifference(axis, at);
    }
    else
    {
      this->Learn(0, axis, at, bin, prediction.Position);
    }
    const int measured =
      this->Levels[0][static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)];
    this->Model.MeanLevel += measured - this->Model.MeanLevel / 16;
    (*this->Planes[0])[static_cast<std::size_t>(axis)].Positions[static_cast<std::size_t>(at)] =
      this->Intervals.GetPosition(bin);
  }

  // The errors to expect of a prediction, from those around.
  int FindLevel(std::size_t of, int axis, std::ptrdiff_t at) const
  {
    const ErrorLevels& levels = this->Levels[of][static_cast<std::size_t>(axis)];
    return (4 *
               (levels[static_cast<std::size_t>(at - 1)] +
                 levels[static_cast<std::size_t>(at - RowStride)] +
                 levels[static_cast<std::size_t>(at)]) +
             2 *
               (levels[static_cast<std::size_t>(at - RowStride - 1)] +
                 levels[static_cast<std::size_t>(at - RowStride + 1)]) +
             8) >>
      4;
  }

  // The linear and the quadratic fit, mixed by the errors that they made around and in the block;
  // and cycles.
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

  // Betters the prediction where cycles lead to the edge: each counts by the inverse of its
  // variance, that of the fit being the one that the level tells.
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

  void FindSides(int axis, std::int32_t room, int quarter, const Prediction& prediction,
    ResidualContext& context) const
  {
    const int spare = std::clamp(
      (MeasureMagnitude(2 * static_cast<std::uint64_t>(room)) - context.Level + 12) / 6, 0, 7);
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

  // The error of a prediction.
  void Learn(std::size_t of, int axis, std::ptrdiff_t at, std::uint32_t bin, std::int32_t predicted)
  {
    const std::int64_t error =
      8 * std::int64_t{ bin } + 4 - (this->Intervals.Locate(predicted) >> 13);
    this->Levels[of][static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)] =
      static_cast<std::uint16_t>(
        MeasureMagnitude(static_cast<std::uint64_t>(error < 0 ? -error : error)));
  }

  void LearnDifference(int axis, std::ptrdiff_t at)
  {
    const auto line = static_cast<std::size_t>(axis);
    const auto place = static_cast<std::size_t>(at);
    const int difference = this->Levels[1][line][place] - this->Levels[2][line][place];
    this->MeanDifference += (256 * difference - this->MeanDifference) / 128;
  }

  Coder& Output;
  CrossingModel& Model;
  ResidualCoder<Coder, Mixed> Residuals;
  const CrossingFit& Fit = CrossingFit::Get();
  CrossingIntervals Intervals;
  std::uint32_t Bins; ///< intervals of an edge
  bool HasMissing;
  int SizeX;
  int SizeY;
  bool IsLast = false;
  int MeanDifference = 2 << 8; ///< of the levels of the linear and the quadratic fit, times 256
  std::array<const SignSlice*, 3> Slices{}; ///< before, this one, after
  std::array<std::array<CrossingPlane, 3>, 3> Memory;
  CrossingPlanes Planes{}; ///< [this slice, the one before, the next one][axis]
  /// Of what was predicted, and if curved of the linear and the quadratic fit: [which][axis].
  std::array<std::array<ErrorLevels, 3>, Curved ? 3 : 1> Levels;
};

} // namespace isosurface

#endif
