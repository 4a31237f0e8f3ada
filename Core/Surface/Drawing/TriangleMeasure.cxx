// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/TriangleMeasure.h"

#include "Ground/Base/ParallelFor.h"
#include "Surface/Drawing/PointPlaces.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

constexpr std::size_t PointsOfRun = std::size_t{ 1 } << 16;

std::size_t CountRuns(std::size_t count, std::size_t length)
{
  return (count + length - 1) / length;
}

/// The bounds of points. A NaN counts for nothing.
struct PointBounds
{
  PointVector Low{ std::numeric_limits<float>::max() };
  PointVector High{ std::numeric_limits<float>::lowest() };

  void Add(PointVector point)
  {
    this->Low = Minimum(point, this->Low);
    this->High = Maximum(point, this->High);
  }
  void Add(const PointBounds& other)
  {
    this->Low = Minimum(other.Low, this->Low);
    this->High = Maximum(other.High, this->High);
  }
  std::array<float, 6> GetValues() const
  {
    const std::array<float, 3> low = this->Low.GetCoordinates();
    const std::array<float, 3> high = this->High.GetCoordinates();
    return { low[0], high[0], low[1], high[1], low[2], high[2] };
  }
  std::array<double, 6> Widen() const
  {
    const std::array<float, 6> values = this->GetValues();
    std::array<double, 6> wide{};
    std::copy(values.begin(), values.end(), wide.begin());
    return wide;
  }
};

struct MeasureOfRun
{
  PointBounds Bounds;
  std::uint32_t ProperTriangles = 0;
  bool IsValid = true; ///< whether all point numbers are those of points
};

/// Measures the triangles [first, last).
template <typename T>
MeasureOfRun MeasureRun(
  const TriangleSurface& surface, const T* connectivity, std::size_t first, std::size_t last)
{
  using Unsigned = std::make_unsigned_t<T>;
  MeasureOfRun run;
  for (std::size_t triangle = first; triangle < last; ++triangle)
  {
    const T* points = connectivity + 3 * triangle;
    const auto a = static_cast<std::size_t>(static_cast<Unsigned>(points[0]));
    const auto b = static_cast<std::size_t>(static_cast<Unsigned>(points[1]));
    const auto c = static_cast<std::size_t>(static_cast<Unsigned>(points[2]));
    if (std::max({ a, b, c }) >= surface.NumberOfPoints)
    {
      run.IsValid = false;
      return run;
    }
    const PointVector atA = LoadPoint(surface, a);
    const PointVector atB = LoadPoint(surface, b);
    const PointVector atC = LoadPoint(surface, c);
    run.Bounds.Add(atA);
    run.Bounds.Add(atB);
    run.Bounds.Add(atC);
    run.ProperTriangles += AreProperCorners(atA, atB, atC) ? 1U : 0U;
  }
  return run;
}

/// The bounds of all points.
PointBounds FindBounds(const TriangleSurface& surface, int threads)
{
  std::vector<PointBounds> runs(CountRuns(surface.NumberOfPoints, PointsOfRun));
  ParallelFor(runs.size(), threads,
    [&](std::size_t run, int)
    {
      const std::size_t last = std::min(surface.NumberOfPoints, (run + 1) * PointsOfRun);
      PointBounds bounds;
      for (std::size_t point = run * PointsOfRun; point < last; ++point)
      {
        bounds.Add(LoadPoint(surface, point));
      }
      runs[run] = bounds;
    });
  PointBounds all;
  for (const PointBounds& run : runs)
  {
    all.Add(run);
  }
  return all;
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

TriangleMeasure MeasureTriangles(const TriangleSurface& surface, int threads)
{
  constexpr std::size_t length = TriangleMeasure::TrianglesOfRun;
  std::vector<MeasureOfRun> runs(CountRuns(surface.NumberOfTriangles, length));
  WithConnectivity(surface.Connectivity,
    [&](const auto* connectivity)
    {
      ParallelFor(runs.size(), threads,
        [&](std::size_t run, int)
        {
          const std::size_t last = std::min(surface.NumberOfTriangles, (run + 1) * length);
          runs[run] = MeasureRun(surface, connectivity, run * length, last);
        });
    });
  TriangleMeasure measure;
  measure.IsValid = true;
  PointBounds bounds;
  for (const MeasureOfRun& run : runs)
  {
    measure.IsValid = measure.IsValid && run.IsValid;
    measure.ProperTriangles.push_back(run.ProperTriangles);
    measure.RunBounds.push_back(run.Bounds.GetValues());
    bounds.Add(run.Bounds);
  }
  if (measure.IsValid && surface.NumberOfTriangles > 0)
  {
    measure.Bounds = bounds.Widen();
    measure.PointBounds = FindBounds(surface, threads).Widen();
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
