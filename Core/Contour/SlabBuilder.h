// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SlabBuilder_h
#define isosurface_SlabBuilder_h

#include "Contour/BrickKernel.h"
#include "Contour/BrickLattice.h"
#include "Contour/BrickScan.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Finds the numbers of the points on a brick's rows of edges, slab by slab: its own from its kept
 * words, those on shared faces from the words of the brick that owns them.
 */
class SlabBuilder
{
public:
  SlabBuilder(
    const BrickLattice& lattice, const BrickScan& scan, std::size_t firstPart, std::size_t brick);

  int GetNumberOfSlabs() const { return this->Self.Size[2] - 1; }

  /// Whether the surface crosses the cells between planes k and k + 1.
  bool IsActive(int k) const;

  /// Those cells; holds until the next call.
  const RowSlab& Build(int k);

private:
  /// A brick of the neighbourhood at the isovalue.
  struct View
  {
    const BrickPart* Part = nullptr;
    const BrickOwnership* Ownership = nullptr;
    std::array<int, 3> Size{};
  };
  /// A vertex of the brick, and the same vertex in the brick that owns an edge from there.
  struct Vertex
  {
    int I = 0;
    int J = 0;
    int K = 0;
  };
  using Rows = std::array<EdgeRow, MaximumBrickSize>;
  using Column = std::array<std::int64_t, MaximumBrickSize>;

  static EdgeRow FindRow(const View& view, int axis, int j, int k);
  const View& GetView(const BrickNeighborhood::Step& step);
  Vertex Translate(const View& owner, const BrickNeighborhood::Step& step, Vertex vertex) const;
  EdgeRow FindRow(int axis, int j, int k);
  std::int64_t FindColumn(int axis, int side, int j, int k);
  void FillPlane(int k);
  void FillZ(int k);

  const BrickLattice& Lattice;
  const BrickScan& Scan;
  std::size_t FirstPart;
  View Self;
  BrickNeighborhood Neighborhood;
  std::array<View, 27> Views; ///< filled as they are asked for
  /// Owners by axis and places; see BrickNeighborhood::FindOwner.
  std::array<std::array<std::array<BrickNeighborhood::Step, 3>, 3>, 3> Owners;

  RowSlab Slab{};
  std::array<Rows, 2> X; ///< of planes with even and with odd numbers
  std::array<Rows, 2> Y;
  Rows Z;
  std::array<std::array<Column, 2>, 2> ColumnY; ///< [column][plane even or odd]
  std::array<Column, 2> ColumnZ;
  std::array<int, 2> Filled{ -1, -1 }; ///< the planes that X and Y hold
};

} // namespace isosurface

#endif
