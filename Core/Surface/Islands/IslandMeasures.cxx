// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Islands/IslandMeasures.h"

#include "Ground/Volume/Vector3.h"
#include "Surface/Contour/WorldTransform.h"
#include "Surface/Islands/SurfaceRanges.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

namespace isosurface
{
namespace
{

/// The whole number of units, which are powers of two; not beyond a maximum, and 0 for NaN.
std::int64_t Round(double value, double maximum, double unitsPerOne)
{
  if (!(std::abs(value) <= maximum))
  {
    value = std::isnan(value) ? 0 : std::copysign(maximum, value);
  }
  return static_cast<std::int64_t>(value * unitsPerOne);
}

/// Measures triangles.
class TriangleRuler
{
public:
  TriangleRuler(const Surface& surface, const IslandUnits& units)
    : Measured(surface)
    , Units(units)
    , AreasPerOne(1 / units.Area)
    , VolumesPerOne(1 / units.Volume)
  {
  }

  void Add(std::size_t a, std::size_t b, std::size_t c, IslandMeasure& sum) const
  {
    const Vector3 first = this->Measured.GetPoint(a);
    const Vector3 second = this->Measured.GetPoint(b);
    const Vector3 third = this->Measured.GetPoint(c);
    const Vector3 normal = Cross(Subtract(second, first), Subtract(third, first));
    const double height = first[2] + second[2] + third[2] - 3 * this->Units.MiddleZ;
    ++sum.Triangles;
    sum.Area +=
      Round(std::sqrt(Dot(normal, normal)) / 2, this->Units.MaximumArea, this->AreasPerOne);
    sum.Volume += Round(normal[2] * height / 6, this->Units.MaximumVolume, this->VolumesPerOne);
  }

private:
  const Surface& Measured;
  const IslandUnits& Units;
  double AreasPerOne;
  double VolumesPerOne;
};

/// The sums of an island that several threads add to.
struct SharedSums
{
  std::atomic<std::uint64_t> Triangles{ 0 };
  std::atomic<std::int64_t> Area{ 0 };
  std::atomic<std::int64_t> Volume{ 0 };
  std::atomic<std::int64_t> FirstId{ std::numeric_limits<std::int64_t>::max() };

  void Add(const IslandMeasure& part)
  {
    this->Triangles.fetch_add(part.Triangles, std::memory_order_relaxed);
    this->Area.fetch_add(part.Area, std::memory_order_relaxed);
    this->Volume.fetch_add(part.Volume, std::memory_order_relaxed);
  }
  void Lower(std::int64_t id)
  {
    std::int64_t first = this->FirstId.load(std::memory_order_relaxed);
    while (id < first && !this->FirstId.compare_exchange_weak(first, id, std::memory_order_relaxed))
    {
    }
  }
};

/// Keeps the sums of the islands that a thread meets again and again, so that threads do not wait
/// for each other where all are on one large island.
class RecentSums
{
public:
  explicit RecentSums(std::vector<SharedSums>& all)
    : All(all)
  {
  }
  IslandMeasure& Of(std::size_t island)
  {
    Entry& entry = this->Entries[island % Size];
    if (entry.Island != island)
    {
      this->Add(entry);
      entry = { island, {} };
    }
    return entry.Sum;
  }
  void AddAll()
  {
    for (Entry& entry : this->Entries)
    {
      this->Add(entry);
    }
  }

private:
  static constexpr std::size_t Size = 64;
  struct Entry
  {
    std::size_t Island = 0;
    IslandMeasure Sum;
  };

  void Add(const Entry& entry)
  {
    if (entry.Sum.Triangles > 0)
    {
      this->All[entry.Island].Add(entry.Sum);
    }
  }

  std::vector<SharedSums>& All;
  std::array<Entry, Size> Entries;
};

/// The point of a triangle that is nearest to a place (Ericson, Real-Time Collision Detection,
/// 2005, section 5.1.5).
Vector3 FindNearestPoint(const Vector3& place, const Vector3& a, const Vector3& b, const Vector3& c)
{
  const auto mix = [](const Vector3& from, const Vector3& along, double share) -> Vector3 {
    return { from[0] + share * along[0], from[1] + share * along[1], from[2] + share * along[2] };
  };
  const Vector3 ab = Subtract(b, a);
  const Vector3 ac = Subtract(c, a);
  const Vector3 ap = Subtract(place, a);
  const double d1 = Dot(ab, ap);
  const double d2 = Dot(ac, ap);
  if (d1 <= 0 && d2 <= 0)
  {
    return a;
  }
  const Vector3 bp = Subtract(place, b);
  const double d3 = Dot(ab, bp);
  const double d4 = Dot(ac, bp);
  if (d3 >= 0 && d4 <= d3)
  {
    return b;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0)
  {
    return mix(a, ab, d1 / (d1 - d3));
  }
  const Vector3 cp = Subtract(place, c);
  const double d5 = Dot(ab, cp);
  const double d6 = Dot(ac, cp);
  if (d6 >= 0 && d5 <= d6)
  {
    return c;
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0)
  {
    return mix(a, ac, d2 / (d2 - d6));
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
  {
    return mix(b, Subtract(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)));
  }
  const double denominator = va + vb + vc;
  return mix(mix(a, ab, vb / denominator), ac, vc / denominator);
}

/// The power of two that is not less than a positive number.
double RoundUpToPowerOfTwo(double number)
{
  return std::exp2(std::ceil(std::log2(number)));
}

} // namespace

TriangleBounds TriangleBounds::Of(const GridGeometry& grid, const GridLines* lines)
{
  const Index3 dimensions = grid.GetDimensions();
  const WorldTransform transform = MakeWorldTransform(grid);
  double diagonal = 0;
  double maximum = 0; // of a coordinate's magnitude
  TriangleBounds bounds;
  for (std::size_t row = 0; row < 3; ++row)
  {
    double low = transform.Points[4 * row + 3];
    double high = low;
    double length = 0;
    for (std::size_t axis = 0; axis < 3 && !lines; ++axis)
    {
      const double step = transform.Points[4 * row + axis];
      const double first = step * static_cast<double>(grid.Extent[2 * axis]);
      const double last = step * static_cast<double>(grid.Extent[2 * axis + 1]);
      low += std::min(first, last);
      high += std::max(first, last);
      length += std::abs(step);
    }
    if (lines && dimensions[row] > 0)
    {
      const std::vector<double>& places = lines->Coordinates[row];
      low = places.front();
      high = places.back();
      for (std::size_t n = 1; n < places.size(); ++n)
      {
        length = std::max(length, places[n] - places[n - 1]);
      }
    }
    diagonal += length * length;
    maximum = std::max({ maximum, std::abs(low), std::abs(high) });
    bounds.LowZ = low;
    bounds.HighZ = high;
  }
  // Points are rounded to float, so that a triangle may reach beyond its cell.
  const double rounding = maximum * std::numeric_limits<float>::epsilon();
  const double length = std::sqrt(diagonal) + 4 * rounding;
  bounds.Area = length * length / 2;
  bounds.LowZ -= rounding;
  bounds.HighZ += rounding;
  return bounds;
}

void TriangleBounds::Extend(const TriangleBounds& other)
{
  const bool isEmpty = this->Area == 0;
  this->Area = std::max(this->Area, other.Area);
  this->LowZ = isEmpty ? other.LowZ : std::min(this->LowZ, other.LowZ);
  this->HighZ = isEmpty ? other.HighZ : std::max(this->HighZ, other.HighZ);
}

IslandUnits::IslandUnits(const TriangleBounds& bounds, std::uint64_t triangles)
  : MiddleZ((bounds.LowZ + bounds.HighZ) / 2)
  , MaximumArea(bounds.Area)
  , MaximumVolume(bounds.Area * (bounds.HighZ - bounds.LowZ) / 2)
{
  constexpr double bits = 62;
  const double parts = std::exp2(bits) / RoundUpToPowerOfTwo(std::max(1.0, double(triangles)));
  if (this->MaximumArea > 0)
  {
    this->Area = RoundUpToPowerOfTwo(this->MaximumArea) / parts;
  }
  if (this->MaximumVolume > 0)
  {
    this->Volume = RoundUpToPowerOfTwo(this->MaximumVolume) / parts;
  }
}

void IslandMeasure::Add(const IslandMeasure& other)
{
  this->Triangles += other.Triangles;
  this->Area += other.Area;
  this->Volume += other.Volume;
  this->FirstId = std::min(this->FirstId, other.FirstId);
}

std::vector<IslandMeasure> MeasureIslands(
  const Surface& surface, const IslandLabels& labels, const IslandUnits& units, int threads)
{
  std::vector<SharedSums> sums(labels.GetNumberOfIslands());
  const TriangleRuler ruler(surface, units);
  WithCells(surface,
    [&](const auto& cells)
    {
      ForRanges(surface.NumberOfCells, threads,
        [&](std::size_t begin, std::size_t end, std::size_t)
        {
          RecentSums recent(sums);
          for (std::size_t cell = begin; cell < end; ++cell)
          {
            IslandMeasure& sum = recent.Of(labels[cells.GetFirstPoint(cell)]);
            cells.ForTriangles(
              cell, [&](std::size_t a, std::size_t b, std::size_t c) { ruler.Add(a, b, c, sum); });
          }
          recent.AddAll();
        });
    });
  ForRanges(surface.NumberOfPoints, threads,
    [&](std::size_t begin, std::size_t end, std::size_t)
    {
      for (std::size_t point = begin; point < end; ++point)
      {
        sums[labels[point]].Lower(surface.GlobalIds[point]);
      }
    });
  std::vector<IslandMeasure> measures;
  measures.reserve(sums.size());
  for (const SharedSums& sum : sums)
  {
    measures.push_back(
      { sum.Triangles.load(), sum.Area.load(), sum.Volume.load(), sum.FirstId.load() });
  }
  return measures;
}

bool NearestIsland::IsNearerThan(const NearestIsland& other) const
{
  return this->SquaredDistance != other.SquaredDistance
    ? this->SquaredDistance < other.SquaredDistance
    : this->FirstId < other.FirstId;
}

NearestIsland FindNearestIsland(const Surface& surface, const IslandLabels& labels,
  const std::vector<IslandMeasure>& measures, const std::vector<std::uint8_t>& areKept,
  const std::array<double, 3>& place, int threads)
{
  NearestIsland nearest;
  std::mutex mutex;
  const auto measure = [&](std::size_t a, std::size_t b, std::size_t c)
  {
    const Vector3 offset = Subtract(place,
      FindNearestPoint(place, surface.GetPoint(a), surface.GetPoint(b), surface.GetPoint(c)));
    return Dot(offset, offset);
  };
  WithCells(surface,
    [&](const auto& cells)
    {
      ForRanges(surface.NumberOfCells, threads,
        [&](std::size_t begin, std::size_t end, std::size_t)
        {
          NearestIsland mine;
          for (std::size_t cell = begin; cell < end; ++cell)
          {
            const std::size_t island = labels[cells.GetFirstPoint(cell)];
            if (areKept[island] != 0)
            {
              cells.ForTriangles(cell,
                [&](std::size_t a, std::size_t b, std::size_t c)
                {
                  // NaN is not near.
                  const NearestIsland one{ measure(a, b, c), measures[island].FirstId };
                  mine = one.SquaredDistance >= 0 && one.IsNearerThan(mine) ? one : mine;
                });
            }
          }
          const std::lock_guard<std::mutex> lock(mutex);
          nearest = mine.IsNearerThan(nearest) ? mine : nearest;
        });
    });
  return nearest;
}

} // namespace isosurface
