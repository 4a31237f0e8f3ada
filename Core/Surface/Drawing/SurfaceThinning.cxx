// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/SurfaceThinning.h"

#include "Ground/Base/HugePages.h"
#include "Ground/Base/ParallelFor.h"
#include "Surface/Drawing/PointPlaces.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

namespace isosurface
{
namespace
{

constexpr std::size_t ItemsOfRun = std::size_t{ 1 } << 16;
constexpr std::uint64_t NoPoint = std::numeric_limits<std::uint64_t>::max();
constexpr int MaximumCells = 512;
/// What fits a processor's first cache.
constexpr std::size_t PointsAtOnce = 1024;

/// Calls body(run, first, last) for runs of [0, count), by several threads at once.
template <typename BodyT>
void ForRuns(std::size_t count, int threads, BodyT&& body)
{
  ParallelFor((count + ItemsOfRun - 1) / ItemsOfRun, threads,
    [&](std::size_t run, int)
    { body(run, run * ItemsOfRun, std::min(count, (run + 1) * ItemsOfRun)); });
}

/// The grid of cells over a surface's bounds.
struct CellGrid
{
  std::array<float, 3> Low{};
  float CellsPerLength = 0;
  std::array<std::uint32_t, 3> Cells{ 1, 1, 1 };

  CellGrid(const std::array<double, 6>& bounds, int cells)
  {
    double longest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      longest = std::max(longest, bounds[2 * axis + 1] - bounds[2 * axis]);
    }
    this->CellsPerLength = longest > 0 ? static_cast<float>(cells / longest) : 0.0F;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Low[axis] = static_cast<float>(bounds[2 * axis]);
      const auto length = static_cast<float>(bounds[2 * axis + 1] - bounds[2 * axis]);
      this->Cells[axis] = static_cast<std::uint32_t>(length * this->CellsPerLength) + 1;
    }
  }

  std::size_t CountCells() const
  {
    return std::size_t{ this->Cells[0] } * this->Cells[1] * this->Cells[2];
  }

  /// The numbers of the cells of some points, and their squared distances from the centres, in
  /// cells. What is not within the grid, a NaN too, is in its first or last cell.
  void FindCells(
    const float* points, std::size_t count, std::uint32_t* cells, float* distances) const
  {
    const std::array<float, 3> last{ static_cast<float>(this->Cells[0] - 1),
      static_cast<float>(this->Cells[1] - 1), static_cast<float>(this->Cells[2] - 1) };
    const auto row = static_cast<std::int32_t>(this->Cells[0]);
    const auto slice = static_cast<std::int32_t>(this->Cells[0] * this->Cells[1]);
    // Signed integers, no calls and no branches: compilers make vectors of this.
    for (std::size_t point = 0; point < count; ++point)
    {
      const float x = (points[3 * point] - this->Low[0]) * this->CellsPerLength;
      const float y = (points[3 * point + 1] - this->Low[1]) * this->CellsPerLength;
      const float z = (points[3 * point + 2] - this->Low[2]) * this->CellsPerLength;
      const auto i = static_cast<std::int32_t>(Limit(x, last[0]));
      const auto j = static_cast<std::int32_t>(Limit(y, last[1]));
      const auto k = static_cast<std::int32_t>(Limit(z, last[2]));
      const float fromX = x - static_cast<float>(i) - 0.5F;
      const float fromY = y - static_cast<float>(j) - 0.5F;
      const float fromZ = z - static_cast<float>(k) - 0.5F;
      cells[point] = static_cast<std::uint32_t>(k * slice + j * row + i);
      distances[point] = fromX * fromX + fromY * fromY + fromZ * fromZ;
    }
  }

private:
  static float Limit(float place, float last)
  {
    const float inside = place > 0.0F ? place : 0.0F;
    return inside < last ? inside : last;
  }
};

/// A point in the order in which a cell prefers them: next to the centre first, then by number.
std::uint64_t MakePreference(float distance, std::size_t point)
{
  // Floats that are not negative have the order of their bits.
  std::uint32_t bits = 0;
  std::memcpy(&bits, &distance, sizeof(bits));
  return (std::uint64_t{ bits } << 32) | static_cast<std::uint32_t>(point);
}

void KeepMinimum(std::atomic<std::uint64_t>& minimum, std::uint64_t value)
{
  std::uint64_t known = minimum.load(std::memory_order_relaxed);
  while (value < known && !minimum.compare_exchange_weak(known, value, std::memory_order_relaxed))
  {
  }
}

/// The points of a surface in the cells of a grid.
class Clusters
{
public:
  Clusters(const TriangleSurface& surface, const CellGrid& grid, int threads)
    : Surface(surface)
    , Threads(threads)
    , CountOfCells(grid.CountCells())
    , PointOfCell(new std::atomic<std::uint64_t>[this->CountOfCells])
    , CellOfPoint(new std::uint32_t[surface.NumberOfPoints])
  {
    AdviseHugePages(this->PointOfCell.get(), this->CountOfCells * sizeof(std::uint64_t));
    AdviseHugePages(this->CellOfPoint.get(), surface.NumberOfPoints * sizeof(std::uint32_t));
    ForRuns(this->CountOfCells, threads,
      [&](std::size_t, std::size_t first, std::size_t last)
      {
        for (std::size_t cell = first; cell < last; ++cell)
        {
          this->PointOfCell[cell].store(NoPoint, std::memory_order_relaxed);
        }
      });
    ForRuns(surface.NumberOfPoints, threads,
      [&](std::size_t, std::size_t first, std::size_t last)
      {
        std::array<float, PointsAtOnce> distances;
        for (std::size_t begin = first; begin < last; begin += PointsAtOnce)
        {
          const std::size_t count = std::min(PointsAtOnce, last - begin);
          std::uint32_t* cells = this->CellOfPoint.get() + begin;
          grid.FindCells(surface.Points + 3 * begin, count, cells, distances.data());
          for (std::size_t index = 0; index < count; ++index)
          {
            KeepMinimum(
              this->PointOfCell[cells[index]], MakePreference(distances[index], begin + index));
          }
        }
      });
  }

  /// Numbers the cells that have points, in their order; returns their points.
  std::vector<std::uint32_t> NumberPoints()
  {
    const std::vector<std::size_t> starts = this->CountPointsOfRuns();
    std::vector<std::uint32_t> points(starts.back());
    ForRuns(this->CountOfCells, this->Threads,
      [&](std::size_t run, std::size_t first, std::size_t last)
      {
        std::size_t number = starts[run];
        for (std::size_t cell = first; cell < last; ++cell)
        {
          const std::uint64_t point = this->PointOfCell[cell].load(std::memory_order_relaxed);
          if (point != NoPoint)
          {
            points[number] = static_cast<std::uint32_t>(point);
            this->PointOfCell[cell].store(number++, std::memory_order_relaxed);
          }
        }
      });
    return points;
  }

  /// The triangles with corners in three cells, in order.
  std::vector<std::uint32_t> ChooseTriangles() const
  {
    const std::size_t triangles = this->Surface.NumberOfTriangles;
    std::vector<std::vector<std::uint32_t>> runs((triangles + ItemsOfRun - 1) / ItemsOfRun);
    WithConnectivity(this->Surface.Connectivity,
      [&](const auto* connectivity)
      {
        ForRuns(triangles, this->Threads,
          [&](std::size_t run, std::size_t first, std::size_t last)
          {
            for (std::size_t triangle = first; triangle < last; ++triangle)
            {
              const auto* points = connectivity + 3 * triangle;
              const std::uint32_t a = this->CellOfPoint[points[0]];
              const std::uint32_t b = this->CellOfPoint[points[1]];
              const std::uint32_t c = this->CellOfPoint[points[2]];
              // No branches: which corners share a cell cannot be predicted.
              if (((a != b) & (b != c) & (a != c)) != 0)
              {
                runs[run].push_back(static_cast<std::uint32_t>(triangle));
              }
            }
          });
      });
    std::vector<std::uint32_t> all;
    std::size_t size = 0;
    for (const auto& run : runs)
    {
      size += run.size();
    }
    all.reserve(size);
    for (const auto& run : runs)
    {
      all.insert(all.end(), run.begin(), run.end());
    }
    return all;
  }

  /// The corners of triangles, by the numbers of NumberPoints.
  std::vector<std::uint32_t> FindCorners(const std::vector<std::uint32_t>& triangles) const
  {
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * triangles.size());
    for (const std::size_t triangle : triangles)
    {
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        const std::int64_t point = this->Surface.Connectivity[3 * triangle + corner];
        corners.push_back(this->GetNumber(this->CellOfPoint[point]));
      }
    }
    return corners;
  }

private:
  /// How many cells with points are before each run of cells, and at the end how many in all.
  std::vector<std::size_t> CountPointsOfRuns() const
  {
    std::vector<std::size_t> counts((this->CountOfCells + ItemsOfRun - 1) / ItemsOfRun + 1);
    ForRuns(this->CountOfCells, this->Threads,
      [&](std::size_t run, std::size_t first, std::size_t last)
      {
        std::size_t count = 0;
        for (std::size_t cell = first; cell < last; ++cell)
        {
          count += this->PointOfCell[cell].load(std::memory_order_relaxed) != NoPoint ? 1 : 0;
        }
        counts[run + 1] = count;
      });
    for (std::size_t run = 1; run < counts.size(); ++run)
    {
      counts[run] += counts[run - 1];
    }
    return counts;
  }

  std::uint32_t GetNumber(std::uint32_t cell) const
  {
    return static_cast<std::uint32_t>(this->PointOfCell[cell].load(std::memory_order_relaxed));
  }

  const TriangleSurface& Surface;
  int Threads;
  std::size_t CountOfCells;
  /// The cell's preferred point (MakePreference); after NumberPoints its number.
  std::unique_ptr<std::atomic<std::uint64_t>[]> PointOfCell;
  std::unique_ptr<std::uint32_t[]> CellOfPoint;
};

/// One point of so many is looked at to choose the cells.
constexpr std::size_t PointStride = 8;

/// How many cells have one of the points that are looked at: a lower bound of the points to keep.
std::size_t EstimatePoints(const TriangleSurface& surface, const CellGrid& grid, int threads)
{
  std::vector<std::atomic<unsigned char>> taken(grid.CountCells());
  std::atomic<std::size_t> count{ 0 };
  ForRuns(surface.NumberOfPoints, threads,
    [&](std::size_t, std::size_t first, std::size_t last)
    {
      std::size_t mine = 0;
      for (std::size_t point = first; point < last; point += PointStride)
      {
        float distance = 0;
        std::uint32_t cell = 0;
        grid.FindCells(surface.Points + 3 * point, 1, &cell, &distance);
        if (taken[cell].load(std::memory_order_relaxed) == 0)
        {
          mine += taken[cell].exchange(1, std::memory_order_relaxed) == 0 ? 1 : 0;
        }
      }
      count += mine;
    });
  return count;
}

/// The number of cells along the longest side with which about limits.Points are kept.
int ChooseCells(const TriangleSurface& surface, const TriangleMeasure& measure,
  const ThinningLimits& limits, int threads)
{
  int cells = std::clamp(limits.Cells, 1, MaximumCells);
  while (cells > 1)
  {
    const std::size_t points = EstimatePoints(surface, CellGrid(measure.Bounds, cells), threads);
    if (points <= limits.Points)
    {
      break;
    }
    // A smooth surface has points in as many cells as the square of their number along a side.
    const double ratio = static_cast<double>(limits.Points) / static_cast<double>(points);
    cells = std::clamp(static_cast<int>(cells * std::sqrt(ratio)), 1, cells - 1);
    if (points < surface.NumberOfPoints / PointStride / 4)
    {
      break; // each cell was found by several points, so hardly any cell was missed
    }
  }
  return cells;
}

} // namespace

ThinnedSurface ThinSurface(const TriangleSurface& surface, const TriangleMeasure& measure,
  const ThinningLimits& limits, int threads)
{
  ThinnedSurface thinned;
  if (surface.NumberOfTriangles == 0)
  {
    return thinned;
  }
  const CellGrid grid(measure.Bounds, ChooseCells(surface, measure, limits, threads));
  Clusters clusters(surface, grid, threads);
  thinned.Points = clusters.NumberPoints();
  thinned.Numbers = clusters.ChooseTriangles();
  thinned.Triangles = clusters.FindCorners(thinned.Numbers);
  return thinned;
}

} // namespace isosurface
