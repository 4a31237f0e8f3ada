// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/PointSampling.h"

#include "Ground/Volume/VertexPlaces.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

namespace isosurface
{
namespace
{

constexpr double Tolerance = 1e-6; // in cells

// A point in its cell: the cell's low vertex, and where in the cell it is, from 0 to 1.
struct PointInCell
{
  Index3 Low{};
  std::array<double, 3> Fraction{};
  std::int64_t Number = 0;
};

// The cells of the points that are within the grid.
class CellFinder
{
public:
  CellFinder(const Index3& dimensions, Interpolation interpolation)
    : Dimensions(dimensions)
    , Interpolating(interpolation)
  {
  }

  void Find(const std::vector<SamplePoint>& points, std::vector<PointInCell>& cells,
    std::uint8_t* isInside) const
  {
    cells.clear();
    for (const SamplePoint& point : points)
    {
      PointInCell cell;
      cell.Number = point.Number;
      const bool isFound = this->FindCell(point.Vertex, cell);
      if (isInside)
      {
        isInside[point.Number] = isFound ? 1 : 0;
      }
      if (isFound)
      {
        cells.push_back(cell);
      }
    }
  }

private:
  bool FindCell(const std::array<double, 3>& vertex, PointInCell& cell) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const auto last = static_cast<double>(this->Dimensions[axis] - 1);
      // Also false if it is NaN.
      if (!(vertex[axis] >= -Tolerance && vertex[axis] <= last + Tolerance))
      {
        return false;
      }
      double place = std::clamp(vertex[axis], 0.0, last);
      if (this->Interpolating == Interpolation::Nearest)
      {
        place = std::floor(place + 0.5);
      }
      // The last vertices are the far ends of the last cells.
      const double low = std::min(std::floor(place), std::max(0.0, last - 1));
      cell.Low[axis] = static_cast<std::int64_t>(low);
      cell.Fraction[axis] = place - low;
    }
    return true;
  }

  Index3 Dimensions;
  Interpolation Interpolating;
};

// The value at a point of a cell whose vertices of a weight above 0 are in the view. The samples of a
// block may be anywhere in memory.
template <typename Value>
Value Interpolate(const SampleView& view, const PointInCell& point)
{
  const auto* first = static_cast<const std::uint8_t*>(view.AtBytes(point.Low));
  const auto load = [&](std::ptrdiff_t offset)
  {
    Value value;
    std::memcpy(&value, first + offset * static_cast<std::ptrdiff_t>(sizeof(Value)), sizeof(value));
    return value;
  };
  // On each axis one vertex or two, with their weights.
  int count[3];
  double weights[3][2];
  std::ptrdiff_t offset = 0; // of the only vertex, if there is but one
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double fraction = point.Fraction[axis];
    const bool isBetween = fraction > 0 && fraction < 1;
    count[axis] = isBetween ? 2 : 1;
    offset += fraction == 1 ? view.Stride[axis] : 0;
    weights[axis][0] = isBetween ? 1 - fraction : 1;
    weights[axis][1] = fraction;
  }
  if (count[0] + count[1] + count[2] == 3)
  {
    return load(offset); // also where a double would not hold it
  }
  double sum = 0;
  for (int z = 0; z < count[2]; ++z)
  {
    for (int y = 0; y < count[1]; ++y)
    {
      for (int x = 0; x < count[0]; ++x)
      {
        const double weight = weights[0][x] * weights[1][y] * weights[2][z];
        sum += weight *
          static_cast<double>(
            load(offset + x * view.Stride[0] + y * view.Stride[1] + z * view.Stride[2]));
      }
    }
  }
  return RoundInterpolated<Value>(sum);
}

// Samples portions of points on one thread.
class PortionSampler
{
public:
  PortionSampler(const LevelSamples& samples, std::size_t variable, QueryStatistics& statistics)
    : Samples(samples)
    , Variable(variable)
    , Statistics(statistics)
  {
  }

  Status Sample(const std::vector<PointInCell>& points, void* values, std::ptrdiff_t stride)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->ReadBlocks(points));
    const ValueType type = this->Samples.GetVolume().GetVariables()[this->Variable].Type;
    DispatchValueType(type,
      [&](auto zero)
      {
        using Value = decltype(zero);
        for (std::size_t point = 0; point < points.size(); ++point)
        {
          const Value value =
            Interpolate<Value>(this->Blocks[this->BlockOfPoint[point]]->View, points[point]);
          std::memcpy(static_cast<std::uint8_t*>(values) +
              points[point].Number * stride * static_cast<std::ptrdiff_t>(sizeof(Value)),
            &value, sizeof(value));
        }
      });
    return Status::Ok();
  }

private:
  // Finds the block of each point, and keeps those of this portion alone.
  Status ReadBlocks(const std::vector<PointInCell>& points)
  {
    std::vector<BlockReference> references;
    this->BlockOfPoint.resize(points.size());
    std::map<Index3, std::size_t> numbers;
    VertexBox cells; // of the block of the point before
    for (std::size_t point = 0; point < points.size(); ++point)
    {
      const Index3& low = points[point].Low;
      if (point > 0 && Contains(cells, low))
      {
        this->BlockOfPoint[point] = this->BlockOfPoint[point - 1];
        continue;
      }
      const Index3 block = this->Samples.FindBlock(low);
      cells = this->Samples.FindCells(block);
      const auto entry = numbers.try_emplace(block, references.size());
      this->BlockOfPoint[point] = entry.first->second;
      if (entry.second)
      {
        references.push_back(this->Samples.GetBlock(block));
      }
    }
    BlockedVolume& volume = this->Samples.GetVolume();
    const std::size_t step = this->Samples.GetTimeStep();
    const int level = this->Samples.GetLevel();
    volume.Prefetch(references, 0, references.size(), step, { this->Variable }, level);
    this->Blocks.clear();
    for (const BlockReference& reference : references)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto read, volume.ReadBlock(reference, step, this->Variable, level, this->Statistics));
      this->Blocks.push_back(std::move(read));
    }
    return Status::Ok();
  }

  static bool Contains(const VertexBox& box, const Index3& vertex)
  {
    return vertex[0] >= box.Low[0] && vertex[0] < box.High[0] && vertex[1] >= box.Low[1] &&
      vertex[1] < box.High[1] && vertex[2] >= box.Low[2] && vertex[2] < box.High[2];
  }

  const LevelSamples& Samples;
  std::size_t Variable;
  QueryStatistics& Statistics;
  DecodedBlocks Blocks;
  std::vector<std::size_t> BlockOfPoint; ///< among Blocks
};

} // namespace

Status SamplePoints(const LevelSamples& samples, std::size_t variable, Interpolation interpolation,
  const PointPortions& points, int threads, void* values, std::ptrdiff_t stride,
  std::uint8_t* isInside, QueryStatistics& statistics, const Progress& progress)
{
  const CellFinder finder(samples.GetBox().GetSize(), interpolation);
  const auto sample = [&](std::size_t portion, QueryStatistics& cost) -> Status
  {
    std::vector<SamplePoint> given;
    std::vector<PointInCell> cells;
    points.Give(portion, given);
    finder.Find(given, cells, isInside);
    return PortionSampler(samples, variable, cost).Sample(cells, values, stride);
  };
  return ReadInParallel(points.Count, threads, sample, statistics, progress);
}

Status SampleArrays(const LevelSamples& samples, const std::vector<std::size_t>& arrays,
  Interpolation interpolation, std::int64_t count,
  const std::function<std::array<double, 3>(std::int64_t point)>& find, int threads,
  const std::vector<void*>& values, std::uint8_t* isInside, const Progress& progress)
{
  const BlockedVolume& volume = samples.GetVolume();
  const int level = samples.GetLevel();
  const VertexPlaces places(volume.GetHeader().Grid.Coarsen(level), volume.GetLines(level));
  constexpr std::int64_t size = 4096;
  PointPortions portions;
  portions.Count = static_cast<std::size_t>((count + size - 1) / size);
  portions.Give = [&](std::size_t portion, std::vector<SamplePoint>& given)
  {
    given.clear();
    const std::int64_t first = static_cast<std::int64_t>(portion) * size;
    for (std::int64_t point = first; point < std::min(count, first + size); ++point)
    {
      given.push_back({ places.FindVertex(find(point)), point });
    }
  };
  QueryStatistics unused;
  return SampleComponents(volume.GetVariables(), arrays, values, progress,
    [&](std::size_t variable, void* first, int stride, const Progress& advance)
    {
      return SamplePoints(samples, variable, interpolation, portions, threads, first, stride,
        isInside, unused, advance);
    });
}

} // namespace isosurface
