// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/PointSampling.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <type_traits>
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

template <typename Value>
Value RoundTo(double value)
{
  if constexpr (std::is_integral_v<Value>)
  {
    return static_cast<Value>(std::round(value));
  }
  else
  {
    return static_cast<Value>(value);
  }
}

// The samples of a block may be anywhere in memory.
template <typename Value>
Value Load(const SampleView& view, const Index3& vertex)
{
  Value value;
  std::memcpy(&value, view.AtBytes(vertex), sizeof(value));
  return value;
}

// The value at a point of a cell whose vertices of a weight above 0 are in the view.
template <typename Value>
Value Interpolate(const SampleView& view, const PointInCell& point)
{
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner)
  {
    double weight = 1;
    Index3 vertex = point.Low;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const bool isHigh = (corner >> axis & 1) != 0;
      weight *= isHigh ? point.Fraction[axis] : 1 - point.Fraction[axis];
      vertex[axis] += isHigh ? 1 : 0;
    }
    if (weight == 1)
    {
      return Load<Value>(view, vertex); // also where a double would not hold it
    }
    if (weight > 0)
    {
      sum += weight * static_cast<double>(Load<Value>(view, vertex));
    }
  }
  return RoundTo<Value>(sum);
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
          const Value value = Interpolate<Value>(*this->Views[point], points[point]);
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
    std::map<Index3, std::shared_ptr<const DecodedBlock>> blocks;
    this->Views.assign(points.size(), nullptr);
    std::vector<BlockReference> ahead;
    std::vector<decltype(blocks.begin())> found(points.size());
    for (std::size_t point = 0; point < points.size(); ++point)
    {
      const Index3 block = this->Samples.FindCover(FindCellVertices(points[point].Low)).Low;
      const bool isSame = point > 0 && found[point - 1]->first == block;
      const auto entry =
        isSame ? std::make_pair(found[point - 1], false) : blocks.try_emplace(block, nullptr);
      found[point] = entry.first;
      if (entry.second)
      {
        ahead.push_back(this->Samples.GetBlock(block));
      }
    }
    BlockedVolume& volume = this->Samples.GetVolume();
    const std::size_t step = this->Samples.GetTimeStep();
    const int level = this->Samples.GetLevel();
    volume.Prefetch(ahead, 0, ahead.size(), step, { this->Variable }, level);
    for (auto& [block, decoded] : blocks)
    {
      auto read = volume.ReadBlock(
        this->Samples.GetBlock(block), step, this->Variable, level, this->Statistics);
      ISOSURFACE_RETURN_IF_ERROR(read.GetStatus());
      decoded = std::move(*read);
    }
    for (std::size_t point = 0; point < points.size(); ++point)
    {
      this->Views[point] = &found[point]->second->View;
    }
    this->Blocks = std::move(blocks);
    return Status::Ok();
  }

  static VertexBox FindCellVertices(const Index3& low)
  {
    return { low, { low[0] + 1, low[1] + 1, low[2] + 1 } };
  }

  const LevelSamples& Samples;
  std::size_t Variable;
  QueryStatistics& Statistics;
  std::map<Index3, std::shared_ptr<const DecodedBlock>> Blocks;
  std::vector<const SampleView*> Views; ///< of each point
};

} // namespace

Status SamplePoints(const LevelSamples& samples, std::size_t variable, Interpolation interpolation,
  const PointPortions& points, int threads, void* values, std::ptrdiff_t stride,
  std::uint8_t* isInside, QueryStatistics& statistics, const Progress& progress)
{
  const CellFinder finder(samples.GetBox().GetSize(), interpolation);
  std::vector<QueryStatistics> costs(static_cast<std::size_t>(threads));
  FirstFailure failure;
  const auto sample = [&](std::size_t portion, QueryStatistics& cost) -> Status
  {
    std::vector<SamplePoint> given;
    std::vector<PointInCell> cells;
    points.Give(portion, given);
    finder.Find(given, cells, isInside);
    return PortionSampler(samples, variable, cost).Sample(cells, values, stride);
  };
  const bool finished = ParallelFor(
    points.Count, threads,
    [&](std::size_t portion, int thread)
    { failure.Run([&] { return sample(portion, costs[static_cast<std::size_t>(thread)]); }); },
    progress);
  for (const QueryStatistics& cost : costs)
  {
    statistics.Add(cost);
  }
  ISOSURFACE_RETURN_IF_ERROR(failure.Get());
  return finished ? Status::Ok() : Status(StatusCode::Aborted, "Reading was aborted.");
}

} // namespace isosurface
