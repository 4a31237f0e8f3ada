// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/VertexMerge.h"

#include "Ground/Base/ParallelFor.h"
#include "Surface/Contour/SlabBuilder.h"

#include <algorithm>
#include <unordered_map>

namespace isosurface
{
namespace
{

constexpr std::size_t VerticesPerBrick =
  std::size_t(MaximumBrickSize) * MaximumBrickSize * MaximumBrickSize;

std::size_t GetVertexInBrick(const VertexPoint& point)
{
  return point.I +
    std::size_t(MaximumBrickSize) * (point.J + std::size_t(MaximumBrickSize) * point.K);
}

bool IsOnFace(const VertexPoint& point, const Index3& size)
{
  return point.I == 0 || point.J == 0 || point.K == 0 || point.I + 1 == size[0] ||
    point.J + 1 == size[1] || point.K + 1 == size[2];
}

struct VertexHash
{
  std::size_t operator()(const Index3& vertex) const
  {
    std::uint64_t hash = 0;
    for (const std::int64_t coordinate : vertex)
    {
      hash = (hash ^ static_cast<std::uint64_t>(coordinate)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

} // namespace

VertexMerge::VertexMerge(const BrickLattice& lattice, BrickScan& scan)
  : Lattice(lattice)
  , Scan(scan)
{
  std::size_t points = 0;
  const std::vector<BrickSurface>& parts = scan.GetSurfaces();
  for (std::size_t part = 0; part < parts.size(); ++part)
  {
    if (parts[part].Inside)
    {
      this->Active.push_back(part);
      points += parts[part].Counts.Points;
    }
  }
  this->Numbers = Buffer<std::int64_t>(points);
  this->AreUsed = std::vector<std::atomic<std::uint8_t>>(points);
}

bool VertexMerge::Run(int threads, const Progress& progress)
{
  const auto workers = static_cast<std::size_t>(std::max(1, threads));
  std::vector<FirstPoints> firstPoints(workers);
  std::vector<std::vector<std::int64_t>> corners(workers);
  ParallelFor(this->Active.size(), threads,
    [&](std::size_t n, int thread)
    { this->MergeWithinBrick(this->Active[n], firstPoints[static_cast<std::size_t>(thread)]); });
  this->MergeAcrossBricks();
  const bool finished = ParallelFor(
    this->Active.size(), threads,
    [&](std::size_t n, int thread)
    { this->CountKept(this->Active[n], corners[static_cast<std::size_t>(thread)]); },
    progress);
  if (!finished)
  {
    return false;
  }
  // Triangles of other bricks use a brick's points too, so these are counted after all triangles.
  ParallelFor(this->Active.size(), threads,
    [&](std::size_t n, int)
    {
      BrickSurface& part = this->Scan.GetSurfaces()[this->Active[n]];
      const auto first = static_cast<std::size_t>(part.FirstPoint);
      part.Kept.Points = static_cast<std::uint32_t>(
        std::count(&this->AreUsed[first], &this->AreUsed[first] + part.Counts.Points, 1));
    });
  std::vector<std::int64_t> firsts;
  std::int64_t count = 0;
  for (const std::size_t part : this->Active)
  {
    firsts.push_back(count);
    count += this->Scan.GetSurfaces()[part].Kept.Points;
  }
  ParallelFor(this->Active.size(), threads,
    [&](std::size_t n, int) { this->NumberPoints(this->Active[n], firsts[n]); });
  for (const std::size_t number : this->Active)
  {
    const BrickSurface& part = this->Scan.GetSurfaces()[number];
    for (std::uint32_t n = 0; n < part.NumberOfVertexPoints; ++n)
    {
      const VertexPoint& point = part.VertexPoints[n];
      if (point.IsMerged)
      {
        std::int64_t& own = this->Numbers[static_cast<std::size_t>(part.FirstPoint) + point.Point];
        own = this->GetNumber(own);
      }
    }
  }
  return true;
}

const std::int64_t* VertexMerge::MakeTriangles(
  std::size_t part, std::vector<std::int64_t>& corners) const
{
  const std::size_t bricks = this->Lattice.GetBricks().size();
  const std::size_t needed = 3 * std::size_t(this->Scan.GetSurfaces()[part].Counts.Triangles);
  corners.resize(std::max(corners.size(), needed));
  SlabBuilder builder(this->Lattice, this->Scan, part / bricks * bricks, part % bricks);
  builder.WriteTriangles(corners.data(), corners.data() + needed);
  return corners.data();
}

void VertexMerge::MergeWithinBrick(std::size_t number, FirstPoints& firstPoints)
{
  constexpr std::uint32_t none = static_cast<std::uint32_t>(-1);
  const BrickSurface& part = this->Scan.GetSurfaces()[number];
  for (std::uint32_t n = 0; n < part.Counts.Points; ++n)
  {
    this->Numbers[static_cast<std::size_t>(part.FirstPoint + n)] = part.FirstPoint + n;
  }
  if (firstPoints.empty())
  {
    firstPoints.assign(VerticesPerBrick, none);
  }
  for (std::uint32_t n = 0; n < part.NumberOfVertexPoints; ++n)
  {
    VertexPoint& point = part.VertexPoints[n];
    std::uint32_t& first = firstPoints[GetVertexInBrick(point)];
    point.IsMerged = first != none;
    first = point.IsMerged ? first : point.Point;
    this->Numbers[static_cast<std::size_t>(part.FirstPoint + point.Point)] =
      part.FirstPoint + first;
  }
  for (std::uint32_t n = 0; n < part.NumberOfVertexPoints; ++n)
  {
    firstPoints[GetVertexInBrick(part.VertexPoints[n])] = none;
  }
}

// Not parallel: the point that stands for a vertex is that of the first part.
void VertexMerge::MergeAcrossBricks()
{
  const std::size_t bricks = this->Lattice.GetBricks().size();
  std::unordered_map<Index3, std::int64_t, VertexHash> firsts;
  std::size_t isovalue = 0;
  for (const std::size_t number : this->Active)
  {
    if (number / bricks != isovalue)
    {
      isovalue = number / bricks;
      firsts.clear();
    }
    const BrickSurface& part = this->Scan.GetSurfaces()[number];
    const VertexBox& vertices = this->Lattice.GetBricks()[number % bricks].Vertices;
    for (std::uint32_t n = 0; n < part.NumberOfVertexPoints; ++n)
    {
      VertexPoint& point = part.VertexPoints[n];
      std::int64_t& own = this->Numbers[static_cast<std::size_t>(part.FirstPoint + point.Point)];
      if (point.IsMerged)
      {
        own = this->GetNumber(own); // the brick's first point may be merged itself
      }
      else if (IsOnFace(point, vertices.GetSize()))
      {
        const auto found = firsts.emplace(
          Index3{ vertices.Low[0] + point.I, vertices.Low[1] + point.J, vertices.Low[2] + point.K },
          own);
        point.IsMerged = !found.second;
        own = found.first->second;
      }
    }
  }
}

void VertexMerge::CountKept(std::size_t number, std::vector<std::int64_t>& corners)
{
  BrickSurface& part = this->Scan.GetSurfaces()[number];
  const std::int64_t* corner = this->MakeTriangles(number, corners);
  part.Kept.Triangles = 0;
  for (std::uint32_t triangle = 0; triangle < part.Counts.Triangles; ++triangle, corner += 3)
  {
    const std::array<std::int64_t, 3> points{ this->GetNumber(corner[0]),
      this->GetNumber(corner[1]), this->GetNumber(corner[2]) };
    if (points[0] != points[1] && points[1] != points[2] && points[2] != points[0])
    {
      ++part.Kept.Triangles;
      for (const std::int64_t point : points)
      {
        this->AreUsed[static_cast<std::size_t>(point)].store(1, std::memory_order_relaxed);
      }
    }
  }
}

// Numbers the points that are not merged. Run() then numbers the merged points.
void VertexMerge::NumberPoints(std::size_t number, std::int64_t first)
{
  const BrickSurface& part = this->Scan.GetSurfaces()[number];
  for (std::uint32_t n = 0; n < part.Counts.Points; ++n)
  {
    const auto point = static_cast<std::size_t>(part.FirstPoint + n);
    if (this->Numbers[point] == part.FirstPoint + n)
    {
      const bool isUsed = this->AreUsed[point].load(std::memory_order_relaxed) != 0;
      this->Numbers[point] = isUsed ? first++ : -1;
    }
  }
}

} // namespace isosurface
