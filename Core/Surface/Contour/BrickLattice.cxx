// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/BrickLattice.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::int64_t CellsPerBrick = MaximumBrickSize - 1;
constexpr std::int64_t LatticeLimit = std::int64_t(1) << 40;

Status MakeBlockError(std::size_t block, const char* reason)
{
  return { StatusCode::InvalidArgument, "Block " + std::to_string(block) + " " + reason + "." };
}

// The vertices that the blocks of each lattice coordinate span on an axis.
class LatticeAxis
{
public:
  // Adds a block; returns false if it contradicts an earlier one.
  bool Add(std::int64_t coordinate, std::int64_t low, std::int64_t high)
  {
    const auto found = this->Spans.emplace(coordinate, std::make_pair(low, high));
    this->MaximumCells = std::max(this->MaximumCells, high - low - 1);
    return found.second || found.first->second == std::make_pair(low, high);
  }

  std::int64_t GetBricksPerBlock() const
  {
    return std::max<std::int64_t>(1, (this->MaximumCells + CellsPerBrick - 1) / CellsPerBrick);
  }

  // Whether neighbours share a layer of vertices, and all but the last block have the same number
  // of bricks.
  bool IsConsistent() const
  {
    const std::pair<const std::int64_t, std::pair<std::int64_t, std::int64_t>>* last = nullptr;
    for (const auto& span : this->Spans)
    {
      if (last)
      {
        const auto [lastLow, lastHigh] = last->second;
        const bool adjacent = span.first == last->first + 1;
        const std::int64_t bricks = (lastHigh - lastLow - 1 + CellsPerBrick - 1) / CellsPerBrick;
        if (adjacent ? span.second.first != lastHigh - 1 || bricks != this->GetBricksPerBlock()
                     : span.second.first < lastHigh - 1)
        {
          return false;
        }
      }
      last = &span;
    }
    return true;
  }

private:
  std::map<std::int64_t, std::pair<std::int64_t, std::int64_t>> Spans;
  std::int64_t MaximumCells = 0;
};

} // namespace

BrickNeighborhood::Step BrickNeighborhood::FindOwner(int axis, int lowerPlace, int upperPlace) const
{
  // Candidates by decreasing coordinates; the upper axis counts first.
  Step beyond;
  bool isBeyondFound = false;
  for (int upper = 1; upper >= -1; --upper)
  {
    for (int lower = 1; lower >= -1; --lower)
    {
      const bool contains =
        (upper == 0 || upper == upperPlace - 1) && (lower == 0 || lower == lowerPlace - 1);
      const Step step = axis == 0 ? Step{ 0, lower, upper }
        : axis == 1               ? Step{ lower, 0, upper }
                                  : Step{ lower, upper, 0 };
      if (!contains || this->Get(step) == NoBrick)
      {
        continue;
      }
      if (!this->AreBeyond[GetIndex(step)])
      {
        return step;
      }
      if (!isBeyondFound)
      {
        beyond = step;
        isBeyondFound = true;
      }
    }
  }
  return beyond;
}

BrickOwnership BrickNeighborhood::ComputeOwnership(const int size[3]) const
{
  const Step self;
  const int last = size[0] - 1;
  const std::uint64_t allCells = (std::uint64_t(1) << last) - 1;
  BrickOwnership ownership{};
  for (int first = 0; first < NumberOfPlaces; ++first)
  {
    for (int second = 0; second < NumberOfPlaces; ++second)
    {
      ownership.X[first][second] = this->FindOwner(0, first, second) == self ? allCells : 0;
      const std::uint64_t bits = first == 0 ? 1
        : first == 2                        ? std::uint64_t(1) << last
                                            : allCells & ~std::uint64_t(1);
      ownership.Y[second] |= this->FindOwner(1, first, second) == self ? bits : 0;
      ownership.Z[second] |= this->FindOwner(2, first, second) == self ? bits : 0;
    }
  }
  return ownership;
}

Result<BrickLattice> BrickLattice::Cut(
  const Index3& dimensions, const BlockSource& source, const GridSides& closedSides)
{
  const std::size_t numberOfBlocks = source.GetNumberOfBlocks();
  std::array<LatticeAxis, 3> axes;
  for (std::size_t block = 0; block < numberOfBlocks; ++block)
  {
    const Index3 lattice = source.GetLatticeCoordinates(block);
    const VertexBox vertices = source.GetVertices(block);
    for (int axis = 0; axis < 3; ++axis)
    {
      if (vertices.Low[axis] < 0 || vertices.High[axis] > dimensions[axis] ||
        vertices.Low[axis] >= vertices.High[axis])
      {
        return MakeBlockError(block, "is empty or reaches beyond the grid");
      }
      if (std::abs(lattice[axis]) > LatticeLimit ||
        !axes[axis].Add(lattice[axis], vertices.Low[axis], vertices.High[axis]))
      {
        return MakeBlockError(block, "does not lie where its lattice coordinates say");
      }
    }
  }
  Index3 bricksPerBlock{};
  for (int axis = 0; axis < 3; ++axis)
  {
    if (!axes[axis].IsConsistent())
    {
      return Status(StatusCode::InvalidArgument,
        "The blocks do not share faces along axis " + std::to_string(axis) + ".");
    }
    bricksPerBlock[axis] = axes[axis].GetBricksPerBlock();
  }

  BrickLattice lattice;
  lattice.FirstBricks.reserve(numberOfBlocks + 1);
  for (std::size_t block = 0; block < numberOfBlocks; ++block)
  {
    lattice.FirstBricks.push_back(lattice.Bricks.size());
    lattice.CutBlock(
      block, source.GetLatticeCoordinates(block), source.GetVertices(block), bricksPerBlock);
    lattice.AddBricksBeyond(lattice.FirstBricks.back(), dimensions, closedSides);
  }
  lattice.FirstBricks.push_back(lattice.Bricks.size());

  lattice.Numbers.reserve(lattice.Bricks.size());
  for (std::size_t brick = 0; brick < lattice.Bricks.size(); ++brick)
  {
    if (!lattice.Numbers.emplace(lattice.Bricks[brick].Coordinates, brick).second)
    {
      return MakeBlockError(lattice.Bricks[brick].Block, "is there twice");
    }
  }
  return lattice;
}

void BrickLattice::CutBlock(
  std::size_t block, const Index3& lattice, const VertexBox& vertices, const Index3& bricksPerBlock)
{
  Index3 count{};
  for (int axis = 0; axis < 3; ++axis)
  {
    // A block without cells on an axis has no bricks, since it contains no surface.
    count[axis] =
      (vertices.High[axis] - vertices.Low[axis] - 1 + CellsPerBrick - 1) / CellsPerBrick;
  }
  for (std::int64_t k = 0; k < count[2]; ++k)
  {
    for (std::int64_t j = 0; j < count[1]; ++j)
    {
      for (std::int64_t i = 0; i < count[0]; ++i)
      {
        Brick brick;
        brick.Block = block;
        const Index3 part{ i, j, k };
        for (int axis = 0; axis < 3; ++axis)
        {
          brick.Coordinates[axis] = lattice[axis] * bricksPerBlock[axis] + part[axis];
          brick.Vertices.Low[axis] = vertices.Low[axis] + part[axis] * CellsPerBrick;
          brick.Vertices.High[axis] =
            std::min(vertices.High[axis], brick.Vertices.Low[axis] + MaximumBrickSize);
        }
        this->Bricks.push_back(brick);
      }
    }
  }
}

void BrickLattice::AddBricksBeyond(
  std::size_t first, const Index3& dimensions, const GridSides& closedSides)
{
  const std::size_t end = closedSides.IsEmpty() ? first : this->Bricks.size();
  for (std::size_t number = first; number < end; ++number)
  {
    const Brick inner = this->Bricks[number];
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      low[axis] = closedSides.HasLow(axis) && inner.Vertices.Low[axis] == 0 ? -1 : 0;
      high[axis] =
        closedSides.HasHigh(axis) && inner.Vertices.High[axis] == dimensions[axis] ? 1 : 0;
    }
    std::array<int, 3> side{};
    for (side[2] = low[2]; side[2] <= high[2]; ++side[2])
    {
      for (side[1] = low[1]; side[1] <= high[1]; ++side[1])
      {
        for (side[0] = low[0]; side[0] <= high[0]; ++side[0])
        {
          Brick brick = inner;
          brick.Side = side;
          for (std::size_t axis = 0; axis < 3; ++axis)
          {
            brick.Coordinates[axis] += side[axis];
            if (side[axis] != 0)
            {
              brick.Vertices.Low[axis] = side[axis] < 0 ? -1 : dimensions[axis] - 1;
              brick.Vertices.High[axis] = brick.Vertices.Low[axis] + 2;
            }
          }
          if (brick.IsBeyond())
          {
            this->Bricks.push_back(brick);
          }
        }
      }
    }
  }
}

BrickNeighborhood BrickLattice::FindNeighborhood(std::size_t brick) const
{
  BrickNeighborhood neighborhood;
  std::size_t slot = 0;
  const Index3& center = this->Bricks[brick].Coordinates;
  for (std::int64_t dz = -1; dz <= 1; ++dz)
  {
    for (std::int64_t dy = -1; dy <= 1; ++dy)
    {
      for (std::int64_t dx = -1; dx <= 1; ++dx)
      {
        const auto found = this->Numbers.find({ center[0] + dx, center[1] + dy, center[2] + dz });
        if (found == this->Numbers.end())
        {
          neighborhood.Bricks[slot++] = NoBrick;
          continue;
        }
        neighborhood.AreBeyond[slot] = this->Bricks[found->second].IsBeyond();
        neighborhood.Bricks[slot++] = found->second;
      }
    }
  }
  return neighborhood;
}

} // namespace isosurface
