// SPDX-License-Identifier: BSD-3-Clause
#include "Drawing/TriangleMeasure.h"

#include "Base/ParallelFor.h"
#include "Drawing/PointPlaces.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <numeric>
#include <type_traits>

namespace isosurface
{
namespace
{

constexpr std::size_t PointsOfRun = std::size_t{ 1 } << 16;

using PointMarks = std::unique_ptr<std::atomic<unsigned char>[]>;

std::size_t CountRuns(std::size_t count, std::size_t length)
{
  return (count + length - 1) / length;
}

/// Marks the points of a run of triangles and counts the proper ones. Returns false if a point
/// number is not one of the surface's points.
template <typename T>
bool MeasureRun(const TriangleSurface& surface, const T* connectivity, std::size_t first,
  std::size_t last, std::atomic<unsigned char>* marks, std::uint32_t& proper)
{
  using Unsigned = std::make_unsigned_t<T>;
  proper = 0;
  for (std::size_t triangle = first; triangle < last; ++triangle)
  {
    const T* points = connectivity + 3 * triangle;
    for (int corner = 0; corner < 3; ++corner)
    {
      const auto point = static_cast<std::size_t>(static_cast<Unsigned>(points[corner]));
      if (point >= surface.NumberOfPoints)
      {
        return false;
      }
      marks[point].store(1, std::memory_order_relaxed);
    }
    proper += IsProperTriangle(surface.Points, points) ? 1U : 0U;
  }
  return true;
}

struct FloatBounds
{
  float Low[3] = { std::numeric_limits<float>::max(), std::numeric_limits<float>::max(),
    std::numeric_limits<float>::max() };
  float High[3] = { std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
    std::numeric_limits<float>::lowest() };

  void Add(const float* low, const float* high)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Low[axis] = low[axis] < this->Low[axis] ? low[axis] : this->Low[axis];
      this->High[axis] = high[axis] > this->High[axis] ? high[axis] : this->High[axis];
    }
  }
};

/// The bounds of the points that have a mark, and of all points.
struct MarkedBounds
{
  FloatBounds Marked;
  FloatBounds All;
};

MarkedBounds FindBounds(
  const TriangleSurface& surface, const std::atomic<unsigned char>* marks, int threads)
{
  std::vector<MarkedBounds> runs(CountRuns(surface.NumberOfPoints, PointsOfRun));
  ParallelFor(runs.size(), threads,
    [&](std::size_t run, int)
    {
      const std::size_t last = std::min(surface.NumberOfPoints, (run + 1) * PointsOfRun);
      MarkedBounds bounds;
      bool allMarked = true;
      for (std::size_t point = run * PointsOfRun; point < last; ++point)
      {
        bounds.All.Add(surface.Points + 3 * point, surface.Points + 3 * point);
        allMarked &= marks[point].load(std::memory_order_relaxed) != 0;
      }
      bounds.Marked = allMarked ? bounds.All : FloatBounds{};
      for (std::size_t point = run * PointsOfRun; !allMarked && point < last; ++point)
      {
        if (marks[point].load(std::memory_order_relaxed) != 0)
        {
          bounds.Marked.Add(surface.Points + 3 * point, surface.Points + 3 * point);
        }
      }
      runs[run] = bounds;
    });
  MarkedBounds all;
  for (const MarkedBounds& run : runs)
  {
    all.Marked.Add(run.Marked.Low, run.Marked.High);
    all.All.Add(run.All.Low, run.All.High);
  }
  return all;
}

std::array<double, 6> Widen(const FloatBounds& bounds)
{
  std::array<double, 6> widened{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    widened[2 * axis] = static_cast<double>(bounds.Low[axis]);
    widened[2 * axis + 1] = static_cast<double>(bounds.High[axis]);
  }
  return widened;
}

template <typename T>
bool AreOffsets(const T* offsets, std::size_t cells, int threads)
{
  std::atomic<bool> are{ true };
  constexpr std::size_t cellsOfRun = std::size_t{ 1 } << 18;
  ParallelFor(CountRuns(cells + 1, cellsOfRun), threads,
    [&](std::size_t run, int)
    {
      const std::size_t last = std::min(cells + 1, (run + 1) * cellsOfRun);
      bool same = true;
      for (std::size_t cell = run * cellsOfRun; cell < last; ++cell)
      {
        same &= offsets[cell] == static_cast<T>(3 * cell);
      }
      if (!same)
      {
        are = false;
      }
    });
  return are;
}

} // namespace

std::size_t TriangleMeasure::CountProperTriangles() const
{
  return std::accumulate(
    this->ProperTriangles.begin(), this->ProperTriangles.end(), std::size_t{ 0 });
}

TriangleMeasure MeasureTriangles(const TriangleSurface& surface, int threads)
{
  TriangleMeasure measure;
  const PointMarks marks(new std::atomic<unsigned char>[surface.NumberOfPoints]());
  constexpr std::size_t length = TriangleMeasure::TrianglesOfRun;
  measure.ProperTriangles.resize(CountRuns(surface.NumberOfTriangles, length));
  std::atomic<bool> valid{ true };
  WithConnectivity(surface.Connectivity,
    [&](const auto* connectivity)
    {
      ParallelFor(measure.ProperTriangles.size(), threads,
        [&](std::size_t run, int)
        {
          const std::size_t last = std::min(surface.NumberOfTriangles, (run + 1) * length);
          if (!MeasureRun(surface, connectivity, run * length, last, marks.get(),
                measure.ProperTriangles[run]))
          {
            valid = false;
          }
        });
    });
  measure.IsValid = valid;
  if (measure.IsValid && surface.NumberOfTriangles > 0)
  {
    const MarkedBounds bounds = FindBounds(surface, marks.get(), threads);
    measure.Bounds = Widen(bounds.Marked);
    measure.PointBounds = Widen(bounds.All);
  }
  return measure;
}

bool AreTriangleOffsets(const std::int32_t* offsets, std::size_t cells, int threads)
{
  return AreOffsets(offsets, cells, threads);
}

bool AreTriangleOffsets(const std::int64_t* offsets, std::size_t cells, int threads)
{
  return AreOffsets(offsets, cells, threads);
}

} // namespace isosurface
