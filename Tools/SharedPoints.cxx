// SPDX-License-Identifier: BSD-3-Clause
#include "SharedPoints.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

using Blocks = std::vector<const EdgeIndexBlock*>;

/// A block within a closed surface has caps alone: a side of so many vertices.
constexpr std::uint64_t PointsOfCaps = 4096;

std::uint64_t CountPoints(const Blocks& blocks)
{
  std::uint64_t points = 0;
  for (const EdgeIndexBlock* block : blocks)
  {
    points += block->NumberOfPoints == 0 ? PointsOfCaps : block->NumberOfPoints;
  }
  return points;
}

/// Groups of blocks between planes across an axis that cut no block, in their order.
std::vector<Blocks> CutAcross(Blocks blocks, std::size_t axis)
{
  std::stable_sort(blocks.begin(), blocks.end(),
    [axis](const EdgeIndexBlock* a, const EdgeIndexBlock* b)
    { return a->Vertices.Low[axis] < b->Vertices.Low[axis]; });
  std::vector<Blocks> groups;
  std::int64_t last = 0;
  for (const EdgeIndexBlock* block : blocks)
  {
    if (groups.empty() || block->Vertices.Low[axis] >= last)
    {
      groups.emplace_back();
    }
    groups.back().push_back(block);
    last = std::max(last, block->Vertices.High[axis] - 1);
  }
  return groups;
}

/// Joins neighbours as long as they have at most `points` together.
std::vector<Blocks> JoinUpTo(std::uint64_t points, std::vector<Blocks> groups)
{
  std::vector<Blocks> joined;
  std::uint64_t sum = 0;
  for (Blocks& group : groups)
  {
    const std::uint64_t own = CountPoints(group);
    if (joined.empty() || sum + own > points)
    {
      joined.emplace_back();
      sum = 0;
    }
    joined.back().insert(joined.back().end(), group.begin(), group.end());
    sum += own;
  }
  return joined;
}

SurfacePortion MakePiece(const Blocks& blocks, bool beginsLayer)
{
  SurfacePortion piece{ blocks.front()->Vertices, CountPoints(blocks), beginsLayer };
  for (const EdgeIndexBlock* block : blocks)
  {
    piece.Box.Extend(block->Vertices);
  }
  return piece;
}

/// Which edge of the grid, or in a closed surface which vertex, a global id names; see ExtractSurface.
struct GridEdge
{
  Index3 Vertex;
  std::size_t Axis;

  GridEdge(std::int64_t id, const Index3& dimensions, std::int64_t closed)
    : Axis(static_cast<std::size_t>(id % 3))
  {
    const std::int64_t layer = closed > 0 ? 1 : 0;
    const Index3 size = { dimensions[0] + 2 * layer, dimensions[1] + 2 * layer,
      dimensions[2] + 2 * layer };
    const std::int64_t vertices = size[0] * size[1] * size[2];
    const bool isVertex = closed > 0 && id >= 3 * closed * vertices;
    this->Axis = isVertex ? 3 : this->Axis;
    const std::int64_t vertex = (isVertex ? id : id / 3) % vertices;
    this->Vertex = { vertex % size[0] - layer, vertex / size[0] % size[1] - layer,
      vertex / (size[0] * size[1]) - layer };
  }

  bool IsInPlane(std::size_t axis, std::int64_t place) const
  {
    return this->Axis != axis && this->Vertex[axis] == place;
  }
};

} // namespace

std::vector<SurfacePortion> CutSurface(const EdgeIndexFile& file, std::uint64_t points)
{
  Blocks blocks;
  for (const EdgeIndexEntry& entry : file.GetEntries())
  {
    if (!entry.Block.IsPreview)
    {
      blocks.push_back(&entry.Block);
    }
  }
  std::vector<SurfacePortion> pieces;
  for (const Blocks& layer : JoinUpTo(points, CutAcross(std::move(blocks), 2)))
  {
    bool beginsLayer = true;
    for (const Blocks& rows : JoinUpTo(points, CutAcross(layer, 1)))
    {
      pieces.push_back(MakePiece(rows, beginsLayer));
      beginsLayer = false;
    }
  }
  return pieces;
}

void SharedPoints::Begin(const SurfacePortion& piece)
{
  this->Box = piece.Box;
  this->Row = std::exchange(this->NextRow, {});
  if (piece.BeginsLayer)
  {
    this->Layer = std::exchange(this->NextLayer, {});
    this->Row.clear();
  }
}

PointNumbers SharedPoints::Number(const Mesh& mesh)
{
  PointNumbers numbers{ std::vector<std::uint64_t>(mesh.NumberOfPoints), this->NumberOfPoints };
  for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
  {
    const std::int64_t id = mesh.GlobalIds[point];
    const GridEdge edge(id, this->Dimensions, this->Closed);
    std::uint64_t number = this->NumberOfPoints;
    const auto find = [&](const Numbers& known)
    {
      const auto found = known.find(id);
      number = found == known.end() ? number : found->second;
    };
    if (edge.IsInPlane(2, this->Box.Low[2]))
    {
      find(this->Layer);
    }
    if (edge.IsInPlane(1, this->Box.Low[1]))
    {
      find(this->Row);
    }
    this->NumberOfPoints += number == this->NumberOfPoints ? 1 : 0;
    numbers.Values[point] = number;
    if (edge.IsInPlane(2, this->Box.High[2] - 1))
    {
      this->NextLayer[id] = number;
    }
    if (edge.IsInPlane(1, this->Box.High[1] - 1))
    {
      this->NextRow[id] = number;
    }
  }
  return numbers;
}

} // namespace isosurface
