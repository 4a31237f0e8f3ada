// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BrickLattice_h
#define isosurface_BrickLattice_h

#include "Base/Status.h"
#include "Contour/BrickKernel.h"
#include "Volume/BlockGrid.h"
#include "Volume/BlockSource.h"
#include "Volume/GridSides.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/**
 * A part of a block, at most 32 cells a side. Where the surface is to be closed, the bricks of a
 * block at the border have neighbours beyond it, of one cell across the border: they belong to the
 * same block, and their outer vertices are outside of every surface.
 */
struct Brick
{
  std::size_t Block = 0;
  Index3 Coordinates{}; ///< in the lattice of bricks
  VertexBox Vertices;
  /// On each axis: -1, 1 for beyond the low or high side of the grid, else 0.
  std::array<int, 3> Side{};

  bool IsBeyond() const { return this->Side != std::array<int, 3>{}; }
};

/// No brick.
constexpr std::size_t NoBrick = static_cast<std::size_t>(-1);

/**
 * The bricks around one, itself included, and which of them makes the point of a shared edge: among
 * the bricks of the lattice that contain an edge, the one with the greatest coordinates, z before y
 * before x; one beyond the grid only if there is no other. (Only the others see the samples that
 * normals at the border are made of.)
 */
struct BrickNeighborhood
{
  /// How the owner of an edge lies from this brick.
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

  /// Where a step stands in Bricks.
  static std::size_t GetIndex(const Step& step)
  {
    const int index = step.X + 1 + 3 * (step.Y + 1) + 9 * (step.Z + 1);
    return static_cast<std::size_t>(index);
  }
  std::size_t Get(const Step& step) const { return this->Bricks[GetIndex(step)]; }

  /// The owner of edges along `axis` at the places (0 near face, 1 between, 2 far face) on the two
  /// axes across, lower axis first.
  Step FindOwner(int axis, int lowerPlace, int upperPlace) const;

  /// What this brick owns, as masks for the kernels.
  BrickOwnership ComputeOwnership(const int size[3]) const;
};

/**
 * All bricks of the blocks of a source, in the order of the blocks, and their neighbours.
 */
class BrickLattice
{
public:
  /// Adds bricks beyond the closed sides. Errors: InvalidArgument for blocks that do not form a
  /// lattice within the grid.
  static Result<BrickLattice> Cut(
    const Index3& dimensions, const BlockSource& source, const GridSides& closedSides = {});

  const std::vector<Brick>& GetBricks() const { return this->Bricks; }

  /// The bricks of block b are numbers [first(b), first(b + 1)).
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
  /// Adds the neighbours beyond the grid of the bricks from `first` on.
  void AddBricksBeyond(std::size_t first, const Index3& dimensions, const GridSides& closedSides);

  std::vector<Brick> Bricks;
  std::vector<std::size_t> FirstBricks;
  std::unordered_map<Index3, std::size_t, Hash> Numbers;
};

} // namespace isosurface

#endif
