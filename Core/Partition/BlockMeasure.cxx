// SPDX-License-Identifier: BSD-3-Clause
#include "Partition/BlockMeasure.h"

#include "Partition/ProcessorClones.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

/// The spectrum has so many bits fewer than the sums. The rounding error is below a thousandth of a
/// cell's face, and the numbers take fewer bytes on disk.
constexpr int DroppedBits = 12;

/// The minimum width of a cell's values, in bins, so that there is no division by 0.
constexpr float MinimumWidth = 1e-6f;
/// The maximum area in a cell, relative to its largest face. Only rounding errors of tiny widths
/// exceed it.
constexpr float MaximumDensity = 8;

constexpr float OverFortyEight = 1.0f / 48;

/// Converts a value to bins from the first edge. NaN and infinities stay as they are.
template <typename T>
class BinCoordinate
{
public:
  explicit BinCoordinate(const SpectrumBins& bins)
    : First(bins.First)
    , Exponent(bins.Exponent)
    // In two steps, since 2^-Exponent may be too large for a double.
    , Scale{ std::ldexp(1.0, -(bins.Exponent / 2)),
      std::ldexp(1.0, -(bins.Exponent - bins.Exponent / 2)) }
    , SmallScale(static_cast<float>(std::ldexp(1.0, -std::clamp(bins.Exponent, -64, 64))))
    , SmallFirst(static_cast<float>(bins.First))
  {
  }

  float operator()(T value) const
  {
    if constexpr (sizeof(T) <= 2)
    {
      return static_cast<float>(value) * this->SmallScale - this->SmallFirst; // exact
    }
    else if constexpr (sizeof(T) == 8 && !std::is_floating_point_v<T>)
    {
      // The difference may be small and the numbers large: it is exact modulo 2^64.
      const std::uint64_t first = static_cast<std::uint64_t>(this->First) << this->Exponent;
      return static_cast<float>(static_cast<double>(static_cast<std::uint64_t>(value) - first) *
        this->Scale[0] * this->Scale[1]);
    }
    else
    {
      return static_cast<float>(static_cast<double>(value) * this->Scale[0] * this->Scale[1] -
        static_cast<double>(this->First));
    }
  }

private:
  std::int64_t First;
  int Exponent;
  double Scale[2];
  float SmallScale;
  float SmallFirst;
};

/// Loads the vertices of `cells` cells along x, `stride` samples apart.
template <typename T, std::size_t N>
void LoadCells(const BinCoordinate<T>& coordinate, const T* from, std::ptrdiff_t stride,
  std::int64_t cells, std::array<float, N>& row)
{
  if (stride == 1 && cells + 1 == static_cast<std::int64_t>(N))
  {
    // The usual case, which the compiler can unroll.
    for (std::size_t i = 0; i < N; ++i)
    {
      row[i] = coordinate(from[i]);
    }
    return;
  }
  for (std::int64_t i = 0; i <= cells; ++i)
  {
    row[static_cast<std::size_t>(i)] = coordinate(from[i * stride]);
  }
}

/// What the kernel takes and gives, row by row.
struct RowPointers
{
  const float* Values[4]; ///< rows of vertices: (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1)
  std::int32_t* From;
  std::int32_t* To;
  std::int32_t* Area;
  std::int32_t* First;
  std::int32_t* Slope;
};

float Square(float value)
{
  return value * value;
}

/// As std::min and std::max. If an argument is NaN, the result is one of both.
float Minimum(float a, float b)
{
  return a < b ? a : b;
}
float Maximum(float a, float b)
{
  return a > b ? a : b;
}

/**
 * Measures a row of cells. From and To are 0 for a cell with a sample that is not finite.
 *
 * With u, v, w from -1/2 to 1/2, the trilinear interpolant of a cell is
 *   mean + gx u + gy v + gz w + hxy uv + hxz uw + hyz vw + k uvw,
 * its variance (gx^2 + gy^2 + gz^2) / 12 + (hxy^2 + hxz^2 + hyz^2) / 144 + k^2 / 1728, and the mean
 * square of its derivative by u gx^2 + (hxy^2 + hxz^2) / 12 + k^2 / 144.
 */
ISOSURFACE_CLONES void MeasureCells(const RowPointers& pointers, std::int64_t cells,
  const MeasureWeights& weights, float bins, float one)
{
  const float *a = pointers.Values[0], *b = pointers.Values[1], *c = pointers.Values[2],
              *d = pointers.Values[3];
  std::int32_t *from = pointers.From, *to = pointers.To, *area = pointers.Area,
               *first = pointers.First, *slope = pointers.Slope;
  const MeasureWeights weight = weights;
#if !defined(__clang__)
#  pragma GCC ivdep
#endif
  for (std::int64_t i = 0; i < cells; ++i)
  {
    const float a0 = a[i], a1 = a[i + 1], b0 = b[i], b1 = b[i + 1];
    const float c0 = c[i], c1 = c[i + 1], d0 = d[i], d1 = d[i + 1];
    const float sum0 = (a0 + b0) + (c0 + d0), sum1 = (a1 + b1) + (c1 + d1);
    const float y0 = (b0 - a0) + (d0 - c0), y1 = (b1 - a1) + (d1 - c1);
    const float z0 = (c0 - a0) + (d0 - b0), z1 = (c1 - a1) + (d1 - b1);
    const float yz0 = (d0 - c0) - (b0 - a0), yz1 = (d1 - c1) - (b1 - a1);
    const float mean = (sum0 + sum1) / 8;
    const float gx = Square(sum1 - sum0) / 16;
    const float gy = Square(y0 + y1) / 16;
    const float gz = Square(z0 + z1) / 16;
    const float hxy = Square(y1 - y0) * OverFortyEight; // a twelfth of the square, as below
    const float hxz = Square(z1 - z0) * OverFortyEight;
    const float hyz = Square(yz0 + yz1) * OverFortyEight;
    const float k = Square(yz1 - yz0) * (OverFortyEight / 3);
    const float variance = gx + gy + gz + hxy + hxz + hyz + k; // times 12
    const float gradient = weight.X * gx + weight.Y * gy + weight.Z * gz + weight.XY * hxy +
      weight.XZ * hxz + weight.YZ * hyz + weight.XYZ * k;

    const float low =
      Minimum(Minimum(Minimum(a0, a1), Minimum(b0, b1)), Minimum(Minimum(c0, c1), Minimum(d0, d1)));
    const float high =
      Maximum(Maximum(Maximum(a0, a1), Maximum(b0, b1)), Maximum(Maximum(c0, c1), Maximum(d0, d1)));
    const bool isFinite = variance <= std::numeric_limits<float>::max(); // neither is NaN
    const float middle = isFinite ? mean : 0;
    const float widest = isFinite ? Minimum(middle - low, high - middle) : 0;
    const float radius = Minimum(std::sqrt(isFinite ? variance : 0) / 2, widest);
    const float begin = Minimum(Maximum(middle - radius, 0), bins);
    const float end = Minimum(Maximum(middle + radius, 0), bins);
    const float steepness = 1 / Maximum(end - begin, MinimumWidth);
    const std::int32_t beginBin = static_cast<std::int32_t>(begin) + 1;
    const std::int32_t endBin = static_cast<std::int32_t>(end) + 1;
    const float rest = (end - static_cast<float>(beginBin)) * steepness;
    const float density = std::sqrt(isFinite ? gradient : 0) * steepness;
    from[i] = isFinite ? beginBin : 0;
    to[i] = isFinite ? endBin : 0;
    // Rounds numbers that are not negative; std::lround would keep the loop from being vectorised.
    // NOLINTBEGIN(bugprone-incorrect-roundings)
    area[i] = static_cast<std::int32_t>(Minimum(density, MaximumDensity) * one + 0.5f);
    first[i] = static_cast<std::int32_t>(Minimum(Maximum(rest, 0), 1) * one + 0.5f);
    // The volume of steeper cells is 0 at the next bin.
    slope[i] = static_cast<std::int32_t>(Minimum(steepness, 1) * one + 0.5f);
    // NOLINTEND(bugprone-incorrect-roundings)
  }
}

std::array<double, 3> GetAbsoluteSpacing(const GridGeometry& grid)
{
  return { std::abs(grid.Spacing[0]), std::abs(grid.Spacing[1]), std::abs(grid.Spacing[2]) };
}

/// The areas of a cell's faces, by the axis normal to the face.
std::array<double, 3> GetFaces(const GridGeometry& grid)
{
  const std::array<double, 3> h = GetAbsoluteSpacing(grid);
  return { h[1] * h[2], h[2] * h[0], h[0] * h[1] };
}

} // namespace

void MeasureSums::Reduce(Communicator& ranks)
{
  std::vector<std::uint64_t> values;
  for (const Change& change : this->Changes)
  {
    values.insert(values.end(), { change.Area, change.Constant, change.Slope });
  }
  ranks.ReduceSum(values);
  for (std::size_t bin = 0; bin < this->Changes.size(); ++bin)
  {
    this->Changes[bin] = { values[3 * bin], values[3 * bin + 1], values[3 * bin + 2] };
  }
}

void MeasureSums::SetMeasures(WorkloadSpectrum& spectrum) const
{
  const auto round = [](std::uint64_t sum)
  {
    // The rounding of slopes may make the sum slightly negative.
    const auto whole = std::max<std::int64_t>(0, static_cast<std::int64_t>(sum));
    return (static_cast<std::uint64_t>(whole) + (1u << (DroppedBits - 1))) >> DroppedBits;
  };
  Change sum;
  for (std::size_t bin = 0; bin < spectrum.Bins.Count; ++bin)
  {
    sum.Area += this->Changes[bin].Area;
    sum.Constant += this->Changes[bin].Constant;
    sum.Slope += this->Changes[bin].Slope;
    spectrum.Area[bin] = round(sum.Area);
    spectrum.Volume[bin] = round(sum.Constant - sum.Slope * bin);
  }
}

double BlockMeasure::GetAreaUnit(const GridGeometry& grid)
{
  const std::array<double, 3> faces = GetFaces(grid);
  return std::ldexp(
    *std::max_element(faces.begin(), faces.end()), DroppedBits - MeasureSums::FractionBits);
}

double BlockMeasure::GetVolumeUnit(const GridGeometry& grid)
{
  const std::array<double, 3> h = GetAbsoluteSpacing(grid);
  return std::ldexp(h[0] * h[1] * h[2], DroppedBits - MeasureSums::FractionBits);
}

std::int64_t BlockMeasure::ChooseRowStride(const GridGeometry& grid)
{
  const Index3 size = grid.GetDimensions();
  const double cells =
    static_cast<double>(size[0]) * static_cast<double>(size[1]) * static_cast<double>(size[2]);
  std::int64_t stride = 1;
  for (double side = 128; stride < 8 && cells > side * side * side; side *= 2)
  {
    stride *= 2;
  }
  return stride;
}

BlockMeasure::BlockMeasure(
  const SpectrumBins& bins, const GridGeometry& grid, std::int64_t rowStride)
  : Bins(bins)
  , RowsOfCells(grid.GetDimensions()[1] - 1)
  , RowStride(rowStride)
  , Sums(bins)
  , MinimumBin(bins.Count)
  , MaximumBin(0)
{
  // |gradient| * volume is, for each term of the interpolant, the norm of the vector of differences
  // along the axes, each times the area of the face normal to its axis.
  const std::array<double, 3> faces = GetFaces(grid);
  const double maximum = *std::max_element(faces.begin(), faces.end());
  std::array<float, 3> squares;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double face = maximum > 0 ? faces[axis] / maximum : 0;
    squares[axis] = static_cast<float>(face * face);
  }
  this->Weights = { squares[0], squares[1], squares[2], squares[0] + squares[1],
    squares[0] + squares[2], squares[1] + squares[2], squares[0] + squares[1] + squares[2] };
}

/// Chooses the row that is measured for a group of RowStride rows and a run of cells along x.
std::int64_t BlockMeasure::ChooseRow(std::int64_t run, std::int64_t group, std::int64_t k) const
{
  // RowStride successive runs, along x or along z, have different rows. Their order is
  // pseudorandom, so that it is not in step with the surface.
  std::uint64_t hash = static_cast<std::uint64_t>(run / this->RowStride) * 0x9e3779b97f4a7c15u ^
    static_cast<std::uint64_t>(group) * 0xc2b2ae3d27d4eb4fu ^
    static_cast<std::uint64_t>(k / this->RowStride) * 0x165667b19e3779f9u;
  hash = (hash ^ (hash >> 31)) * 0xbf58476d1ce4e5b9u;
  const auto order = static_cast<std::int64_t>(hash >> 61);
  return group * this->RowStride + ((run ^ k ^ order) & (this->RowStride - 1));
}

void BlockMeasure::Count(const SampleView& samples)
{
  const Index3 size = samples.Box.GetSize();
  if (this->Bins.Count == 0 || size[0] < 2 || size[1] < 2 || size[2] < 2)
  {
    return;
  }
  DispatchValueType(samples.Type, [&](auto zero) { this->CountCells<decltype(zero)>(samples); });
}

template <typename T>
void BlockMeasure::CountCells(const SampleView& samples)
{
  const BinCoordinate<T> coordinate(this->Bins);
  const VertexBox& box = samples.Box;
  const auto countRun =
    [&](std::int64_t begin, std::int64_t cells, std::int64_t j, std::int64_t k, std::int64_t weight)
  {
    std::array<CellRow, 4> rows;
    for (std::size_t row = 0; row < rows.size(); ++row)
    {
      const auto up = static_cast<std::int64_t>(row);
      LoadCells(coordinate, samples.At<T>({ begin, j + up % 2, k + up / 2 }), samples.Stride[0],
        cells, rows[row]);
    }
    this->CountRun(rows, cells, weight);
  };

  const std::int64_t last = box.High[1] - 1;
  // If the grid's last group is incomplete, all of its rows are measured.
  const std::int64_t grouped = this->RowsOfCells - this->RowsOfCells % this->RowStride;
  for (std::int64_t k = box.Low[2]; k + 1 < box.High[2]; ++k)
  {
    for (std::int64_t begin = box.Low[0], end = 0; begin + 1 < box.High[0]; begin = end)
    {
      const std::int64_t run = begin / CellsAtOnce;
      end = std::min((run + 1) * CellsAtOnce, box.High[0] - 1);
      const std::int64_t groups = (std::min(last, grouped) + this->RowStride - 1) / this->RowStride;
      for (std::int64_t group = box.Low[1] / this->RowStride; group < groups; ++group)
      {
        const std::int64_t j = this->ChooseRow(run, group, k);
        if (j >= box.Low[1] && j < last)
        {
          countRun(begin, end - begin, j, k, this->RowStride);
        }
      }
      for (std::int64_t j = std::max(box.Low[1], grouped); j < last; ++j)
      {
        countRun(begin, end - begin, j, k, 1);
      }
    }
  }
}

void BlockMeasure::CountRun(
  const std::array<CellRow, 4>& rows, std::int64_t cells, std::int64_t weight)
{
  const std::uint64_t one = static_cast<std::uint64_t>(weight) << MeasureSums::FractionBits;
  CellRun run;
  const RowPointers pointers = { { rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data() },
    run.From.data(), run.To.data(), run.Area.data(), run.First.data(), run.Slope.data() };
  MeasureCells(
    pointers, cells, this->Weights, static_cast<float>(this->Bins.Count), static_cast<float>(one));
  this->AddRun(run, cells, one);
}

void BlockMeasure::AddRun(const CellRun& run, std::int64_t cells, std::uint64_t one)
{
  MeasureSums::Change* changes = this->Sums.Changes.data();
  std::int32_t minimum = std::numeric_limits<std::int32_t>::max();
  std::int32_t maximum = 0;
  std::uint64_t whole = 0;
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(cells); ++cell)
  {
    const std::int32_t from = std::min<std::int32_t>(run.From[cell], this->Bins.Count);
    const std::int32_t to = std::min<std::int32_t>(run.To[cell], this->Bins.Count);
    if (to == 0)
    {
      continue;
    }
    whole += one;
    minimum = std::min(minimum, from);
    maximum = std::max(maximum, to);
    if (from == to)
    {
      changes[from].Constant -= one;
      continue;
    }
    const auto area = static_cast<std::uint64_t>(run.Area[cell]);
    const auto slope = static_cast<std::uint64_t>(run.Slope[cell]);
    const std::uint64_t constant =
      static_cast<std::uint64_t>(run.First[cell]) + slope * static_cast<std::uint64_t>(from);
    changes[from].Area += area;
    changes[from].Constant += constant - one;
    changes[from].Slope += slope;
    changes[to].Area -= area;
    changes[to].Constant -= constant;
    changes[to].Slope -= slope;
  }
  changes[0].Constant += whole;
  this->MinimumBin = std::min(this->MinimumBin, static_cast<std::size_t>(minimum));
  this->MaximumBin = std::max(this->MaximumBin, static_cast<std::size_t>(maximum));
}

void BlockMeasure::CountUniform(ValueType type, ValueKey key, const VertexBox& box)
{
  const Index3 size = box.GetSize();
  if (this->Bins.Count == 0 || size[0] < 2 || size[1] < 2 || size[2] < 2)
  {
    return;
  }
  const float coordinate = DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      return BinCoordinate<T>(this->Bins)(MakeValueOfKey<T>(key));
    });
  if (!std::isfinite(coordinate))
  {
    return;
  }
  const auto count = static_cast<float>(this->Bins.Count);
  const auto last = static_cast<std::size_t>(std::clamp(coordinate, 0.0f, count));
  const std::size_t bin = std::min<std::size_t>(last + 1, this->Bins.Count);
  const auto cells = static_cast<std::uint64_t>((size[0] - 1) * (size[1] - 1) * (size[2] - 1));
  this->Sums.Changes[0].Constant += cells << MeasureSums::FractionBits;
  this->Sums.Changes[bin].Constant -= cells << MeasureSums::FractionBits;
  this->MinimumBin = std::min(this->MinimumBin, bin);
  this->MaximumBin = std::max(this->MaximumBin, bin);
}

void BlockMeasure::MoveTo(MeasureSums& sums)
{
  const auto move = [&](std::size_t bin)
  {
    MeasureSums::Change& mine = this->Sums.Changes[bin];
    sums.Changes[bin].Area += mine.Area;
    sums.Changes[bin].Constant += mine.Constant;
    sums.Changes[bin].Slope += mine.Slope;
    mine = {};
  };
  move(0);
  for (std::size_t bin = std::max<std::size_t>(1, this->MinimumBin); bin <= this->MaximumBin; ++bin)
  {
    move(bin);
  }
  this->MinimumBin = this->Bins.Count;
  this->MaximumBin = 0;
}

} // namespace isosurface
