// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BrickLattice_h
#define isosurface_BrickLattice_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridSides.h"
#include "Surface/Contour/BrickKernel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/**
 * A part of a block, at most 32 cells a side. If the surface is closed at a side of the grid, the
 * bricks there have neighbours beyond that side, one cell wide. These belong to the same block, and
 * their outer vertices are outside for every isovalue.
 */
struct Brick
{
  std::size_t Block = 0;
  Index3 Coordinates{}; ///< in the lattice of bricks
  VertexBox Vertices;
  /// On each axis: -1 beyond the low side of the grid, 1 beyond the high side, otherwise 0.
  std::array<int, 3> Side{};

  bool IsBeyond() const { return this->Side != std::array<int, 3>{}; }
};

/// No brick.
constexpr std::size_t NoBrick = static_cast<std::size_t>(-1);

/**
 * A brick and its neighbours, and the owner of each shared edge, that is, the brick that makes its
 * point: among the bricks that contain the edge, the one with the maximum coordinates, z before y
 * before x. Bricks beyond the grid own an edge only if no other brick contains it, since they do
 * not have the samples for normals at the border.
 */
struct BrickNeighborhood
{
  /// A step from this brick to a neighbour: -1, 0 or 1 on each axis.
  struct Step
  {
    int X = 0;
    int Y = 0;
    int Z = 0;
    bool operator==(const Step& other) const
    {
      return this->X == other.X && this->Y == other.Y && this->Z == other.Z;
    }
  };

  std::array<std::size_t, 27> Bricks; ///< at (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1), or NoBrick
  std::array<bool, 27> AreBeyond{};   ///< Brick::IsBeyond of each

  /// The index of a step in Bricks.
  static std::size_t GetIndex(const Step& step)
  {
    const int index = step.X + 1 + 3 * (step.Y + 1) + 9 * (step.Z + 1);
    return static_cast<std::size_t>(index);
  }
  std::size_t Get(const Step& step) const { return this->Bricks[GetIndex(step)]; }

  /// The owner of edges along `axis` at these places (see NumberOfPlaces) on the two axes across,
  /// the lower axis first.
  Step FindOwner(int axis, int lowerPlace, int upperPlace) const;

  /// The edges that this brick owns.
  BrickOwnership ComputeOwnership(const int size[3]) const;
};

/// The bricks of all blocks of a source, in the order of the blocks.
class BrickLattice
{
public:
  /// Cuts the blocks into bricks, and adds bricks beyond the closed sides. Errors: InvalidArgument
  /// if the blocks do not form a lattice within the grid.
  static Result<BrickLattice> Cut(
    const Index3& dimensions, const BlockSource& source, const GridSides& closedSides = {});

  const std::vector<Brick>& GetBricks() const { return this->Bricks; }

  std::size_t GetNumberOfBlocks() const { return this->FirstBricks.size() - 1; }

  /// The bricks of block b are GetFirstBrick(b) .. GetFirstBrick(b + 1) - 1.
  std::size_t GetFirstBrick(std::size_t block) const { return this->FirstBricks[block]; }

  BrickNeighborhood FindNeighborhood(std::size_t brick) const;

private:
  struct Hash
  {
    std::size_t operator()(const Index3& coordinates) const
    {
      std::uint64_t hash = 0;
      for (const std::int64_t coordinate : coordinates)
      {
        hash = (hash ^ static_cast<std::uint64_t>(coordinate)) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 29;
      }
      return static_cast<std::size_t>(hash);
    }
  };

  void CutBlock(std::size_t block, const Index3& lattice, const VertexBox& vertices,
    const Index3& bricksPerBlock);
  /// Adds the bricks beyond the grid for the bricks from `first` on.
  void AddBricksBeyond(std::size_t first, const Index3& dimensions, const GridSides& closedSides);

  std::vector<Brick> Bricks;
  std::vector<std::size_t> FirstBricks;
  std::unordered_map<Index3, std::size_t, Hash> Numbers;
};

} // namespace isosurface

#endif
