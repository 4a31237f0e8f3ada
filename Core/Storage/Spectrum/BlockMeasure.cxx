// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/BlockMeasure.h"

#include "Ground/Base/ProcessorClones.h"
#include "Ground/Volume/Vector3.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

/// The spectrum has so many bits fewer than the sums. The rounding error is below a thousandth of a
/// cell's face, and the numbers take fewer bytes on disk.
constexpr int DroppedBits = 12;

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

/// Most rows have so many cells; a loop over a constant number becomes a few vectors.
constexpr std::int64_t UsualCells = 16;

/// Loads the four lines of vertices around a row of cells, whose vertices are `stride` samples apart.
template <typename T>
ISOSURFACE_CLONES void LoadCells(const BinCoordinate<T>& coordinate,
  const std::array<const T*, 4>& from, std::ptrdiff_t stride, std::int64_t cells,
  const std::array<float*, 4>& to)
{
  for (std::size_t line = 0; line < from.size(); ++line)
  {
    const T* __restrict samples = from[line];
    float* __restrict row = to[line];
    if (stride == 1 && cells == UsualCells)
    {
      for (std::int64_t i = 0; i < UsualCells; ++i)
      {
        row[i] = coordinate(samples[i]);
      }
      row[UsualCells] = coordinate(samples[UsualCells]);
      continue;
    }
    for (std::int64_t i = 0; i <= cells; ++i)
    {
      row[i] = coordinate(samples[i * stride]);
    }
  }
}

std::array<double, 3> GetAbsoluteSpacing(const GridGeometry& grid)
{
  return { std::abs(grid.Spacing[0]), std::abs(grid.Spacing[1]), std::abs(grid.Spacing[2]) };
}

/// The areas of a cell's faces, by the axis normal to the face, from its lengths.
std::array<double, 3> GetFaces(const std::array<double, 3>& h)
{
  return { h[1] * h[2], h[2] * h[0], h[0] * h[1] };
}

/// A cell of a grid.
struct CellShape
{
  double Volume = 0;
  std::array<double, 3> Faces{}; ///< areas, by the axis across the face
  /// Twice the scalar products of faces as vectors, of those across x and y, x and z, y and z; 0 in a
  /// grid whose axes are perpendicular.
  std::array<double, 3> Products{};

  double GetLargestFace() const
  {
    return *std::max_element(this->Faces.begin(), this->Faces.end());
  }
};

/// Whether the axes are of length 1 and perpendicular but for rounding, as those of a turned grid are.
bool ArePerpendicular(const std::array<double, 9>& direction)
{
  constexpr double rounding = 1e-6;
  for (std::size_t a = 0; a < 3; ++a)
  {
    for (std::size_t b = a; b < 3; ++b)
    {
      const double product = Dot({ direction[a], direction[3 + a], direction[6 + a] },
        { direction[b], direction[3 + b], direction[6 + b] });
      if (std::abs(product - (a == b ? 1 : 0)) > rounding)
      {
        return false;
      }
    }
  }
  return true;
}

CellShape FindShape(const GridGeometry& grid)
{
  const std::array<double, 3> h = GetAbsoluteSpacing(grid);
  if (ArePerpendicular(grid.Direction))
  {
    return { h[0] * h[1] * h[2], GetFaces(h), {} };
  }
  std::array<Vector3, 3> edges;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (std::size_t row = 0; row < 3; ++row)
    {
      edges[axis][row] = grid.Direction[3 * row + axis] * grid.Spacing[axis];
    }
  }
  const Vector3 x = Cross(edges[1], edges[2]);
  const Vector3 y = Cross(edges[2], edges[0]);
  const Vector3 z = Cross(edges[0], edges[1]);
  return { std::abs(Dot(edges[0], x)),
    { std::sqrt(Dot(x, x)), std::sqrt(Dot(y, y)), std::sqrt(Dot(z, z)) },
    { 2 * Dot(x, y), 2 * Dot(x, z), 2 * Dot(y, z) } };
}

/// |gradient| * volume is, for each term of the interpolant, the norm of the sum of the faces as
/// vectors, each times the difference along its axis.
MeasureWeights MakeWeights(const CellShape& cell)
{
  const double largest = cell.GetLargestFace();
  std::array<float, 3> squares;
  std::array<float, 3> products;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double face = largest > 0 ? cell.Faces[axis] / largest : 0;
    squares[axis] = static_cast<float>(face * face);
    products[axis] = static_cast<float>(largest > 0 ? cell.Products[axis] / largest / largest : 0);
  }
  return { squares[0], squares[1], squares[2], squares[0] + squares[1], squares[0] + squares[2],
    squares[1] + squares[2], squares[0] + squares[1] + squares[2], products[0], products[1],
    products[2] };
}

std::uint64_t Scale(std::int64_t number, double factor)
{
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(number) * factor));
}

} // namespace

std::vector<std::uint64_t> MeasureSums::GetNumbers() const
{
  std::vector<std::uint64_t> numbers;
  numbers.reserve(3 * this->Changes.size());
  for (const Change& change : this->Changes)
  {
    numbers.insert(numbers.end(), { change.Area, change.Constant, change.Slope });
  }
  return numbers;
}

void MeasureSums::SetNumbers(const std::vector<std::uint64_t>& numbers)
{
  for (std::size_t bin = 0; bin < this->Changes.size(); ++bin)
  {
    this->Changes[bin] = { numbers[3 * bin], numbers[3 * bin + 1], numbers[3 * bin + 2] };
  }
}

std::uint64_t MeasureSums::Round(std::uint64_t sum)
{
  // The rounding of slopes may make the sum slightly negative.
  const auto whole = std::max<std::int64_t>(0, static_cast<std::int64_t>(sum));
  return (static_cast<std::uint64_t>(whole) + (1u << (DroppedBits - 1))) >> DroppedBits;
}

void MeasureSums::SetMeasures(WorkloadSpectrum& spectrum) const
{
  Change sum;
  for (std::size_t bin = 0; bin < spectrum.Bins.Count; ++bin)
  {
    sum += this->Changes[bin];
    spectrum.Area[bin] = Round(sum.Area);
    spectrum.Volume[bin] = Round(sum.Constant - sum.Slope * bin);
  }
}

double BlockMeasure::GetAreaUnit(const GridGeometry& grid)
{
  return std::ldexp(FindShape(grid).GetLargestFace(), DroppedBits - MeasureSums::FractionBits);
}

double BlockMeasure::GetVolumeUnit(const GridGeometry& grid)
{
  return std::ldexp(FindShape(grid).Volume, DroppedBits - MeasureSums::FractionBits);
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
  const SpectrumBins& bins, const MeasuredGrid& grid, std::int64_t rowStride)
  : Bins(bins)
  , Grid(grid)
  , RowsOfCells(grid.Geometry.GetDimensions()[1] - 1)
  , RowStride(rowStride)
  , Sums(bins)
{
  this->Weights = MakeWeights(FindShape(grid.Geometry));
}

void BlockMeasure::SetBins(const SpectrumBins& bins)
{
  this->Bins = bins;
  this->Sums.Changes.resize(std::max(this->Sums.Changes.size(), bins.Count + std::size_t{ 1 }));
}

double BlockMeasure::GetLength(std::size_t axis, std::int64_t cell, std::int64_t cells) const
{
  const GridLines& lines = *this->Grid.Lines;
  return (lines.At(axis, cell + cells) - lines.At(axis, cell)) / this->Grid.Geometry.Spacing[axis];
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
          const std::int64_t first = group * this->RowStride;
          this->CountRow<T>(samples, coordinate, begin, end, { j, k, first, this->RowStride });
        }
      }
      for (std::int64_t j = std::max(box.Low[1], grouped); j < last; ++j)
      {
        this->CountRow<T>(samples, coordinate, begin, end, { j, k, j, 1 });
      }
    }
  }
  this->CountPending();
}

/// Counts the cells [begin, end) of a row, at most CellsAtOnce.
template <typename T, typename Coordinate>
void BlockMeasure::CountRow(const SampleView& samples, const Coordinate& coordinate,
  std::int64_t begin, std::int64_t end, const RowPlace& row)
{
  static_assert(UsualCells == CellsAtOnce, "a whole run is the usual row");
  const auto load =
    [&](std::int64_t first, std::int64_t cells, std::array<CellRow, 4>& rows, std::int64_t place)
  {
    const T* const corner = samples.At<T>({ first, row.J, row.K });
    const T* const above = corner + samples.Stride[2];
    const std::array<float*, 4> to = { rows[0].data() + place, rows[1].data() + place,
      rows[2].data() + place, rows[3].data() + place };
    LoadCells(coordinate, { corner, corner + samples.Stride[1], above, above + samples.Stride[1] },
      samples.Stride[0], cells, to);
  };
  PendingRuns& pending = this->Pending;
  if (!this->Grid.Lines)
  {
    if (pending.Count == RunsAtOnce || pending.Weight != row.Rows)
    {
      this->CountPending();
      pending.Weight = row.Rows;
    }
    load(begin, end - begin, pending.Rows, pending.Places);
    pending.Places += end - begin + 1;
    pending.Ends[static_cast<std::size_t>(pending.Count++)] = pending.Places - 1;
    return;
  }
  std::array<CellRow, 4>& rows = pending.Rows; // nothing is pending
  for (std::int64_t next = begin; begin < end; begin = next)
  {
    const double length = this->GetLength(0, begin);
    while (next < end && this->GetLength(0, next) == length)
    {
      ++next;
    }
    load(begin, next - begin, rows, 0);
    this->CountLinedRun(rows, begin, next - begin, row);
  }
}

void BlockMeasure::CountPending()
{
  PendingRuns& pending = this->Pending;
  if (pending.Count == 0)
  {
    return;
  }
  const std::uint64_t one = static_cast<std::uint64_t>(pending.Weight) << MeasureSums::FractionBits;
  const std::array<CellRow, 4>& rows = pending.Rows;
  CellRun run;
  const RowPointers pointers = { { rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data() },
    run.From.data(), run.To.data(), run.Area.data(), run.First.data(), run.Slope.data() };
  const std::int64_t cells = pending.Places - 1;
  MeasureCells(
    pointers, cells, this->Weights, static_cast<float>(this->Bins.Count), static_cast<float>(one));
  for (std::int64_t ended = 0; ended + 1 < pending.Count; ++ended)
  {
    // What is between two runs is no cell.
    run.To[static_cast<std::size_t>(pending.Ends[static_cast<std::size_t>(ended)])] = 0;
  }
  this->AddRun(run, cells, one);
  pending.Count = 0;
  pending.Places = 0;
}

void BlockMeasure::CountLinedRun(
  const std::array<CellRow, 4>& rows, std::int64_t begin, std::int64_t cells, const RowPlace& place)
{
  const std::array<double, 3> spacing = GetAbsoluteSpacing(this->Grid.Geometry);
  const std::array<double, 3> lengths = { this->GetLength(0, begin), this->GetLength(1, place.J),
    this->GetLength(2, place.K) };
  CellShape shape;
  shape.Faces =
    GetFaces({ lengths[0] * spacing[0], lengths[1] * spacing[1], lengths[2] * spacing[2] });
  const double face = shape.GetLargestFace();
  const double meanFace = FindShape(this->Grid.Geometry).GetLargestFace();
  // The row stands for the height of all rows of its group.
  const double height = this->GetLength(1, place.FirstRow, place.Rows) / lengths[1];
  const double areaScale = face / meanFace * height;
  const double volumeScale = lengths[0] * lengths[1] * lengths[2] * height;
  constexpr std::int64_t one = std::int64_t{ 1 } << MeasureSums::FractionBits;

  CellRun run;
  const RowPointers pointers = { { rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data() },
    run.From.data(), run.To.data(), run.Area.data(), run.First.data(), run.Slope.data() };
  MeasureCells(pointers, cells, MakeWeights(shape), static_cast<float>(this->Bins.Count),
    static_cast<float>(one));
  const std::uint64_t volume = Scale(one, volumeScale);
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(cells); ++cell)
  {
    if (run.To[cell] == 0)
    {
      continue;
    }
    this->AddCell(run.From[cell], run.To[cell],
      { Scale(run.Area[cell], areaScale), Scale(run.First[cell], volumeScale),
        Scale(run.Slope[cell], volumeScale) },
      volume);
    this->Sums.Changes[0].Constant += volume;
  }
}

/// Adds what a cell has in its bins [from, to): its area, and its volume, which is change.Constant
/// at `from` and falls by change.Slope from bin to bin; below them the volume is `one`.
void BlockMeasure::AddCell(
  std::int32_t from, std::int32_t to, const MeasureSums::Change& change, std::uint64_t one)
{
  MeasureSums::Change* changes = this->Sums.Changes.data();
  if (from == to)
  {
    changes[from].Constant -= one;
    return;
  }
  const std::uint64_t constant = change.Constant + change.Slope * static_cast<std::uint64_t>(from);
  changes[from].Area += change.Area;
  changes[from].Constant += constant - one;
  changes[from].Slope += change.Slope;
  changes[to].Area -= change.Area;
  changes[to].Constant -= constant;
  changes[to].Slope -= change.Slope;
}

void BlockMeasure::AddRun(const CellRun& run, std::int64_t cells, std::uint64_t one)
{
  MeasureSums::Change* changes = this->Sums.Changes.data();
  std::uint64_t whole = 0;
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(cells); ++cell)
  {
    const std::int32_t from = run.From[cell];
    const std::int32_t to = run.To[cell];
    if (to == 0)
    {
      continue;
    }
    whole += one;
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
  const std::uint64_t volume = this->GetVolume(box);
  this->Sums.Changes[0].Constant += volume;
  this->Sums.Changes[bin].Constant -= volume;
}

/// The volume of the cells of a box, each rounded by itself, so that it does not depend on how the
/// grid is cut.
std::uint64_t BlockMeasure::GetVolume(const VertexBox& box) const
{
  const Index3 size = box.GetSize();
  constexpr std::int64_t one = std::int64_t{ 1 } << MeasureSums::FractionBits;
  if (!this->Grid.Lines)
  {
    return static_cast<std::uint64_t>((size[0] - 1) * (size[1] - 1) * (size[2] - 1) * one);
  }
  std::uint64_t volume = 0;
  for (std::int64_t k = box.Low[2]; k + 1 < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j + 1 < box.High[1]; ++j)
    {
      const double face = this->GetLength(1, j) * this->GetLength(2, k);
      for (std::int64_t i = box.Low[0]; i + 1 < box.High[0]; ++i)
      {
        volume += Scale(one, this->GetLength(0, i) * face);
      }
    }
  }
  return volume;
}

void BlockMeasure::MoveTo(MeasureSums& sums)
{
  for (std::size_t bin = 0; bin <= this->Bins.Count; ++bin)
  {
    sums.Changes[bin] += std::exchange(this->Sums.Changes[bin], {});
  }
}

} // namespace isosurface
