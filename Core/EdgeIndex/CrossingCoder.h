// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingCoder_h
#define isosurface_CrossingCoder_h

#include "EdgeIndex/CrossingFit.h"
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
  explicit CrossingModel(bool mixed)
    : Residuals(mixed, Priors.Crossings)
  {
  }
  ResidualModel Residuals;
  AdaptiveBit Missing;
  int MeanLevel = 20 * 16; ///< of errors in eighths of an interval, times 16
};

/**
 * Codes where on the crossed edges of a block the surface is, slice after slice: the rows of a
 * slice, of each row the edges along x, y, then z (to the next slice). An edge is cut into equal
 * intervals; the interval is predicted by a plane fitted to the decoded crossings of all three
 * directions nearby (see CrossingFit).
 */
template <typename Coder, bool Mixed>
class CrossingCoder
{
public:
  CrossingCoder(
    Coder& coder, CrossingModel& model, std::uint32_t bins, bool missing, int sizeX, int sizeY)
    : Output(coder)
    , Model(model)
    , Residuals(coder, model.Residuals)
    , Bins(bins)
    , HasMissing(missing)
    , SizeX(sizeX)
    , SizeY(sizeY)
  {
    this->Reciprocal = (std::uint64_t{ 1 } << 40) / bins;
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
    for (auto& levels : this->Levels)
    {
      std::fill_n(levels.begin(), used, static_cast<std::uint16_t>(model.MeanLevel / 16));
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
    const CrossingFit::Result fit = Mixed
      ? this->Fit.Predict(axis, x, y, at, inside, this->Slices, this->Planes)
      : this->Fit.PredictParallel(axis, x, y, at, this->Planes);
    // In units of 2^-16 intervals.
    const std::int64_t position = std::int64_t{ fit.Position } * this->Bins;
    const auto middle = static_cast<std::int32_t>(
      std::min<std::int64_t>(position >> 16, std::int64_t{ this->Bins } - 1));
    const int quarter = static_cast<int>(
      std::min<std::int64_t>((position - (std::int64_t{ middle } << 16)) >> 14, 3));
    const bool lowerFirst = quarter < 2;
    const auto last = static_cast<std::int32_t>(this->Bins) - 1;
    const std::int32_t room = std::min(middle, last - middle);

    auto& levels = this->Levels[static_cast<std::size_t>(axis)];
    const int level = (4 *
                          (levels[static_cast<std::size_t>(at - 1)] +
                            levels[static_cast<std::size_t>(at - RowStride)] +
                            levels[static_cast<std::size_t>(at)]) +
                        2 *
                          (levels[static_cast<std::size_t>(at - RowStride - 1)] +
                            levels[static_cast<std::size_t>(at - RowStride + 1)]) +
                        8) >>
      4;
    ResidualContext context;
    context.Level = std::max(level - 16, 0);
    this->FindSides(axis, level, room, quarter, fit, context);

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
    this->Learn(axis, at, bin, position);
  }

  void FindSides(int axis, int level, std::int32_t room, int quarter,
    const CrossingFit::Result& fit, ResidualContext& context) const
  {
    const int spare = std::clamp(
      (MeasureMagnitude(2 * static_cast<std::uint64_t>(room)) - context.Level + 12) / 6, 0, 7);
    context.Sides[0] = static_cast<std::uint32_t>(spare);
    if constexpr (Mixed)
    {
      const auto fine = static_cast<std::uint32_t>(std::clamp(level / 3, 0, 15));
      const auto steep = static_cast<std::uint32_t>(fit.Steepness);
      const auto side = static_cast<std::uint32_t>(quarter);
      const auto sixteenth = static_cast<std::uint32_t>(std::min(fit.Position >> 12, 15));
      context.Sides[0] |= side << 3;
      context.Sides[1] = fine | side << 4;
      context.Sides[2] = steep | static_cast<std::uint32_t>(axis) << 3;
      context.Sides[3] = sixteenth | side << 4;
      context.Sides[4] = steep | static_cast<std::uint32_t>(std::min(fit.Number, 7)) << 3;
    }
  }

  void Learn(int axis, std::ptrdiff_t at, std::uint32_t bin, std::int64_t position)
  {
    const std::int64_t error = 8 * std::int64_t{ bin } + 4 - (position >> 13);
    const int measured = MeasureMagnitude(static_cast<std::uint64_t>(error < 0 ? -error : error));
    this->Levels[static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)] =
      static_cast<std::uint16_t>(measured);
    this->Model.MeanLevel += measured - this->Model.MeanLevel / 16;
    (*this->Planes[0])[static_cast<std::size_t>(axis)].Positions[static_cast<std::size_t>(at)] =
      static_cast<std::int16_t>((2 * std::uint64_t{ bin } + 1) * this->Reciprocal >> 31);
  }

  Coder& Output;
  CrossingModel& Model;
  ResidualCoder<Coder, Mixed> Residuals;
  const CrossingFit& Fit = CrossingFit::Get();
  std::uint32_t Bins;
  bool HasMissing;
  int SizeX;
  int SizeY;
  bool IsLast = false;
  std::array<const SignSlice*, 3> Slices{}; ///< before, this one, after
  std::uint64_t Reciprocal = 0;             ///< 2^40 / Bins
  std::array<std::array<CrossingPlane, 3>, 3> Memory;
  CrossingPlanes Planes{}; ///< [this slice, the one before, the next one][axis]
  std::array<std::array<std::uint16_t, CrossingPlaneSize>, 3> Levels;
};

} // namespace isosurface

#endif
