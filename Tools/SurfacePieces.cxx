// SPDX-License-Identifier: BSD-3-Clause
#include "SurfacePieces.h"

#include <algorithm>

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

SurfacePiece MakePiece(const Blocks& blocks, bool beginsLayer)
{
  SurfacePiece piece{ blocks.front()->Vertices, CountPoints(blocks), beginsLayer };
  for (const EdgeIndexBlock* block : blocks)
  {
    piece.Box.Extend(block->Vertices);
  }
  return piece;
}

} // namespace

std::vector<SurfacePiece> CutSurface(const EdgeIndexFile& file, std::uint64_t points)
{
  Blocks blocks;
  for (const EdgeIndexEntry& entry : file.GetEntries())
  {
    if (!entry.Block.IsPreview)
    {
      blocks.push_back(&entry.Block);
    }
  }
  std::vector<SurfacePiece> pieces;
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

} // namespace isosurface
