// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/PlaneLattice.h"

#include "Ground/Base/Buffer.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/Vector3.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

Vector3 AddScaled(const Vector3& a, double factor, const Vector3& b)
{
  return { a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2] };
}

Vector3 Normalize(const Vector3& a)
{
  const double length = std::sqrt(Dot(a, a));
  return { a[0] / length, a[1] / length, a[2] / length };
}

void SetColumn(GridGeometry& grid, std::size_t column, const Vector3& direction)
{
  for (std::size_t row = 0; row < 3; ++row)
  {
    grid.Direction[3 * row + column] = direction[row];
  }
}

// How steep the axes of a grid are to a plane: 1 for a normal of the plane, 0 for an axis in it.
class Steepness
{
public:
  Steepness(const GridGeometry& grid, const Vector3& normal)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Axes[axis] =
        Normalize({ grid.Direction[axis], grid.Direction[3 + axis], grid.Direction[6 + axis] });
      this->Values[axis] = std::abs(Dot(this->Axes[axis], normal));
    }
  }

  const Vector3& GetAxis(std::size_t axis) const { return this->Axes[axis]; }
  std::size_t FindMaximum() const { return this->Find(std::max_element(begin(), end())); }
  std::size_t FindMinimum() const { return this->Find(std::min_element(begin(), end())); }
  // Whether two of the axes lie in the plane.
  bool IsAligned() const
  {
    return std::count_if(begin(), end(), [](double value) { return value < 1e-9; }) == 2;
  }

private:
  using Iterator = std::array<double, 3>::const_iterator;
  Iterator begin() const { return this->Values.begin(); }
  Iterator end() const { return this->Values.end(); }
  std::size_t Find(Iterator value) const { return static_cast<std::size_t>(value - begin()); }

  std::array<Vector3, 3> Axes{};
  std::array<double, 3> Values{};
};

// A row of samples, and the same row of the next layer.
struct TwoRows
{
  const std::uint8_t* First;
  std::ptrdiff_t ToSecond; ///< in samples
  std::ptrdiff_t Stride;   ///< in samples
  std::int64_t Count;
};

// What is `fraction` of the way from the first row to the second one.
template <typename Value>
void InterpolateRow(const TwoRows& rows, double fraction, Value* to, std::ptrdiff_t stride)
{
  constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(Value));
  for (std::int64_t sample = 0; sample < rows.Count; ++sample)
  {
    Value low;
    Value high; // may be anywhere in memory
    const std::uint8_t* from = rows.First + sample * rows.Stride * size;
    std::memcpy(&low, from, sizeof(low));
    std::memcpy(&high, from + rows.ToSecond * size, sizeof(high));
    to[sample * stride] = RoundInterpolated<Value>(
      (1 - fraction) * static_cast<double>(low) + fraction * static_cast<double>(high));
  }
}

// Where the plane cuts the edges of the box that the grid's vertices span.
std::vector<Vector3> CutEdges(const VertexPlaces& places, const Index3& dimensions,
  const Vector3& origin, const Vector3& normal)
{
  Vector3 corners[8];
  double heights[8];
  double scale = 0;
  for (std::size_t corner = 0; corner < 8; ++corner)
  {
    Vector3 vertex{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      vertex[axis] = (corner >> axis & 1) != 0 ? static_cast<double>(dimensions[axis] - 1) : 0.0;
    }
    corners[corner] = places.FindPoint(vertex);
    heights[corner] = Dot(Subtract(corners[corner], origin), normal);
    scale = std::max(scale, std::abs(heights[corner]));
  }
  // A plane on a face of the grid cuts it, whatever the rounding.
  for (double& height : heights)
  {
    height = std::abs(height) <= 1e-12 * scale ? 0 : height;
  }
  std::vector<Vector3> cuts;
  for (std::size_t corner = 0; corner < 8; ++corner)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::size_t other = corner | (std::size_t{ 1 } << axis);
      const double low = heights[corner];
      const double high = heights[other];
      if (other == corner || std::min(low, high) > 0 || std::max(low, high) < 0)
      {
        continue;
      }
      const double part = low == high ? 0 : low / (low - high);
      const Vector3 edge = Subtract(corners[other], corners[corner]);
      cuts.push_back(AddScaled(corners[corner], part, edge));
      if (low == high)
      {
        cuts.push_back(corners[other]);
      }
    }
  }
  return cuts;
}

// The smallest distance of neighbouring vertices of a regular grid; the smallest mean distance on
// an axis of a rectilinear one. Axes of one vertex do not count.
double FindSpacing(const VertexPlaces& places, const Index3& dimensions)
{
  double spacing = std::numeric_limits<double>::infinity();
  const Vector3 first = places.FindPoint({ 0, 0, 0 });
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (dimensions[axis] > 1)
    {
      Vector3 end{};
      end[axis] = static_cast<double>(dimensions[axis] - 1);
      const Vector3 edge = Subtract(places.FindPoint(end), first);
      spacing = std::min(spacing, std::sqrt(Dot(edge, edge)) / end[axis]);
    }
  }
  return std::isfinite(spacing) ? spacing : 1;
}

// The smallest spacing at which a rectangle has at most so many vertices, of which there are more
// than one: (width / spacing + 1) * (height / spacing + 1) = points.
double FindSpacingWithin(double width, double height, double points)
{
  const double sum = width + height;
  return (sum + std::sqrt(sum * sum + 4 * (points - 1) * width * height)) / (2 * (points - 1));
}

} // namespace

std::optional<PlaneLattice> PlaneLattice::Make(
  const GridGeometry& grid, const GridLines* lines, const Plane& plane, double maximumPoints)
{
  const double length = std::sqrt(Dot(plane.Normal, plane.Normal));
  if (grid.GetNumberOfVertices() == 0 || !(length > 0) || !std::isfinite(length))
  {
    return std::nullopt;
  }
  PlaneLattice lattice{ VertexPlaces(grid, lines) };
  lattice.Image.Unit = grid.Unit;
  const Vector3 normal = Normalize(plane.Normal);
  const std::vector<Vector3> cuts =
    CutEdges(lattice.Places, grid.GetDimensions(), plane.Origin, normal);
  if (cuts.empty())
  {
    return std::nullopt;
  }
  const Steepness steepness(lines ? GridGeometry() : grid, normal);
  if (!lines && steepness.IsAligned())
  {
    lattice.AlignTo(grid, steepness.FindMaximum(), plane.Origin);
  }
  if (!lattice.Axis || lattice.CountPoints() > maximumPoints)
  {
    lattice.Axis.reset();
    const Vector3 axis = steepness.GetAxis(steepness.FindMinimum());
    const Vector3 first = Normalize(AddScaled(axis, -Dot(axis, normal), normal));
    lattice.Cover(cuts, { first, Cross(normal, first), normal },
      FindSpacing(lattice.Places, grid.GetDimensions()), maximumPoints);
  }
  return lattice;
}

double PlaneLattice::CountPoints() const
{
  return static_cast<double>(this->Image.GetNumberOfVertices());
}

void PlaneLattice::AlignTo(const GridGeometry& grid, std::size_t axis, const Vector3& point)
{
  this->Axis = axis;
  const double exact = this->Places.FindVertex(point)[axis];
  const double nearest = std::round(exact);
  constexpr double tolerance = 1e-6; // of a cell: rounded coordinates mean the vertices
  this->Vertex = std::abs(exact - nearest) < tolerance ? nearest : exact;
  const double moved = static_cast<double>(grid.Extent[2 * axis]) + this->Vertex;
  for (std::size_t row = 0; row < 3; ++row)
  {
    this->Image.Origin[row] =
      grid.Origin[row] + moved * (grid.Direction[3 * row + axis] * grid.Spacing[axis]);
  }
  this->Image.Extent[4] = this->Image.Extent[5] = 0;
  for (std::size_t column = 0; column < 3; ++column)
  {
    const std::size_t from = column < 2 ? this->GetImageAxis(column) : axis;
    this->Image.Spacing[column] = grid.Spacing[from];
    SetColumn(this->Image, column,
      { grid.Direction[from], grid.Direction[3 + from], grid.Direction[6 + from] });
    if (column < 2)
    {
      this->Image.Extent[2 * column] = grid.Extent[2 * from];
      this->Image.Extent[2 * column + 1] = grid.Extent[2 * from + 1];
    }
  }
}

void PlaneLattice::Cover(const std::vector<Vector3>& cuts, const std::array<Vector3, 3>& axes,
  double spacing, double maximumPoints)
{
  const Vector3& start = cuts.front();
  std::array<double, 2> low{};
  std::array<double, 2> length{};
  this->Image.Origin = start;
  for (std::size_t column = 0; column < 2; ++column)
  {
    double high = 0;
    for (const Vector3& cut : cuts)
    {
      const double place = Dot(Subtract(cut, start), axes[column]);
      low[column] = std::min(low[column], place);
      high = std::max(high, place);
    }
    length[column] = high - low[column];
    this->Image.Origin = AddScaled(this->Image.Origin, low[column], axes[column]);
  }
  const double fit = FindSpacingWithin(length[0], length[1], maximumPoints);
  spacing = std::max(spacing, fit);
  this->Image.Spacing = { spacing, spacing, spacing };
  this->Image.Extent[4] = this->Image.Extent[5] = 0;
  for (std::size_t column = 0; column < 3; ++column)
  {
    SetColumn(this->Image, column, axes[column]);
  }
  for (std::size_t column = 0; column < 2; ++column)
  {
    this->Image.Extent[2 * column] = 0;
    // Rounded, so that a length of whole cells ends at a vertex.
    this->Image.Extent[2 * column + 1] =
      static_cast<std::int64_t>(std::floor(length[column] / spacing + 1e-6));
  }
  this->ImagePlaces = VertexPlaces(this->Image);
}

Vector3 PlaneLattice::FindVertex(const Index3& imageVertex) const
{
  Vector3 place{ static_cast<double>(imageVertex[0]), static_cast<double>(imageVertex[1]), 0 };
  if (this->Axis)
  {
    Vector3 vertex{};
    vertex[*this->Axis] = this->Vertex;
    vertex[this->GetImageAxis(0)] = place[0];
    vertex[this->GetImageAxis(1)] = place[1];
    return vertex;
  }
  return this->Places.FindVertex(this->ImagePlaces.FindPoint(place));
}

Status PlaneLattice::Sample(const LevelSamples& samples, std::size_t variable,
  Interpolation interpolation, const VertexBox& part, int threads, void* values,
  std::ptrdiff_t stride, std::uint8_t* isInside, QueryStatistics& statistics,
  const Progress& progress) const
{
  if (!this->IsAligned())
  {
    return SamplePoints(samples, variable, interpolation, this->MakePortions(part), threads, values,
      stride, isInside, statistics, progress);
  }
  if (isInside)
  {
    std::fill_n(isInside, part.GetNumberOfVertices(), std::uint8_t{ 1 });
  }
  return this->SampleAligned(
    samples, variable, interpolation, part, threads, values, stride, statistics, progress);
}

Status PlaneLattice::SampleAligned(const LevelSamples& samples, std::size_t variable,
  Interpolation interpolation, const VertexBox& part, int threads, void* values,
  std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress) const
{
  const std::size_t axis = *this->Axis;
  const std::size_t first = this->GetImageAxis(0);
  const std::size_t second = this->GetImageAxis(1);
  const auto last = static_cast<double>(samples.GetBox().High[axis] - 1);
  double place = std::clamp(this->Vertex, 0.0, last);
  place = interpolation == Interpolation::Nearest ? std::floor(place + 0.5) : place;
  const double layer = std::floor(place);

  VertexBox vertices; // of the layer
  vertices.Low[axis] = static_cast<std::int64_t>(layer);
  vertices.High[axis] = vertices.Low[axis] + 1;
  vertices.Low[first] = part.Low[0];
  vertices.High[first] = part.High[0];
  vertices.Low[second] = part.Low[1];
  vertices.High[second] = part.High[1];
  const auto copyPart = [&](const VertexBox& own, const SampleView& view)
  {
    DispatchValueType(view.Type,
      [&](auto zero)
      {
        using Value = decltype(zero);
        for (std::int64_t row = own.Low[second]; row < own.High[second]; ++row)
        {
          Index3 from = own.Low;
          from[second] = row;
          auto* to = static_cast<Value*>(values) +
            static_cast<std::ptrdiff_t>(part.FindIndex({ own.Low[first], row, part.Low[2] })) *
              stride;
          const TwoRows rows = { view.AtBytes(from), view.Stride[axis], view.Stride[first],
            own.High[first] - own.Low[first] };
          if (place == layer)
          {
            CopySamples(to, stride, rows.First, rows.Stride, rows.Count, sizeof(Value));
          }
          else
          {
            InterpolateRow<Value>(rows, place - layer, to, stride);
          }
        }
      });
  };
  BlockedVolume& volume = samples.GetVolume();
  if (samples.GetLevel() == 0 && volume.IsAtAddress(samples.GetTimeStep(), variable))
  {
    VertexBox needed = vertices;
    needed.High[axis] += place == layer ? 0 : 1;
    const ValueType type = volume.GetVariables()[variable].Type;
    Buffer<std::uint8_t> bytes(
      static_cast<std::size_t>(needed.GetNumberOfVertices()) * GetValueSize(type));
    const ReadingStop stop(progress);
    ISOSURFACE_RETURN_IF_ERROR(
      volume.ReadSource(samples.GetTimeStep(), variable, needed, bytes.GetData(), statistics));
    copyPart(vertices, MakeSampleView(type, needed, bytes.GetData()));
    return Status::Ok();
  }
  const BlockBox cover = samples.FindCover(vertices);
  std::vector<BlockReference> blocks;
  VisitVertices({ cover.Low, cover.High },
    [&](const Index3& block) { blocks.push_back(samples.GetBlock(block)); });
  const auto copy = [&](const BlockReference& block, const SampleView& view)
  {
    const Index3 at = samples.GetBlockGrid().GetBlockCoordinates(block.Block);
    copyPart(samples.FindCells(at).Intersect(vertices), view);
  };
  return VisitBlocks(volume, samples.GetTimeStep(), variable, samples.GetLevel(), blocks, threads,
    copy, statistics, progress);
}

PointPortions PlaneLattice::MakePortions(const VertexBox& part) const
{
  constexpr std::int64_t side = 64;
  const Index3 size = part.GetSize();
  const std::int64_t tilesPerRow = (size[0] + side - 1) / side;
  PointPortions portions;
  portions.Count = static_cast<std::size_t>(tilesPerRow * ((size[1] + side - 1) / side));
  portions.Give = [this, part, tilesPerRow](std::size_t tile, std::vector<SamplePoint>& points)
  {
    const auto number = static_cast<std::int64_t>(tile);
    VertexBox box{ part.Low, part.High };
    box.Low[0] += number % tilesPerRow * side;
    box.Low[1] += number / tilesPerRow * side;
    box.High[0] = std::min(part.High[0], box.Low[0] + side);
    box.High[1] = std::min(part.High[1], box.Low[1] + side);
    points.clear();
    VisitVertices(box,
      [&](const Index3& vertex)
      {
        points.push_back(
          { this->FindVertex(vertex), static_cast<std::int64_t>(part.FindIndex(vertex)) });
      });
  };
  return portions;
}

std::optional<LevelLattice> FindLatticeWithin(
  const BlockedVolume& volume, const Plane& plane, double maximumPoints, int firstLevel)
{
  const GridGeometry& finest = volume.GetHeader().Grid;
  const auto whole = PlaneLattice::Make(finest, volume.GetLines(0), plane);
  Plane shown = plane;
  std::optional<LevelLattice> found;
  for (int level = firstLevel; whole && level < volume.GetNumberOfLevels(); ++level)
  {
    const GridGeometry grid = finest.Coarsen(level);
    auto lattice = PlaneLattice::Make(grid, volume.GetLines(level), shown);
    if (!lattice && whole->IsAligned())
    {
      const Index3 size = grid.GetDimensions();
      shown.Origin = VertexPlaces(grid).FindPoint({ static_cast<double>(size[0] - 1),
        static_cast<double>(size[1] - 1), static_cast<double>(size[2] - 1) });
      lattice = PlaneLattice::Make(grid, nullptr, shown);
    }
    if (!lattice)
    {
      break;
    }
    found = LevelLattice{ level, std::move(*lattice) };
    if (found->Lattice.CountPoints() <= maximumPoints)
    {
      return found;
    }
  }
  if (found)
  {
    found->Lattice = *PlaneLattice::Make(
      finest.Coarsen(found->Level), volume.GetLines(found->Level), shown, maximumPoints);
  }
  return found;
}

} // namespace isosurface
