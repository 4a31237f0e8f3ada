// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SlabBuilder_h
#define isosurface_SlabBuilder_h

#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/BrickScan.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * Finds the numbers of the points on a brick's edges, slab by slab: from the brick's own words, and
 * for shared edges from the words of the brick that owns them.
 */
class SlabBuilder
{
public:
  SlabBuilder(
    const BrickLattice& lattice, const BrickScan& scan, std::size_t firstPart, std::size_t brick);

  int GetNumberOfSlabs() const { return this->Self.Size[2] - 1; }

  /// Whether the surface crosses the cells between planes k and k + 1.
  bool IsActive(int k) const;

  /// The slab between planes k and k + 1. Valid until the next call.
  const RowSlab& Build(int k);

  /// Writes the triangles of all slabs; returns the end of what was written. Values between that
  /// and `end` may be overwritten.
  template <typename Id>
  Id* WriteTriangles(Id* next, Id* end);

private:
  using Rows = std::array<EdgeRow, MaximumBrickSize>;
  using Column = std::array<std::int64_t, MaximumBrickSize>;

  const NumberedRows& GetRows(const BrickNeighborhood::Step& step);
  EdgeRow FindSharedRow(int axis, const BrickNeighborhood::Step& owner, int j, int k);
  std::int64_t FindColumnPoint(int axis, int side, int j, int k);
  void FillPlane(int k);
  void FillSharedRows(int k);
  void FillColumns(int axis, int k, Column& first, Column& last);

  const BrickLattice& Lattice;
  const BrickScan& Scan;
  std::size_t FirstPart;
  const BrickKernels& Kernels;
  const std::uint64_t* Visible; ///< see BrickSurface
  NumberedRows Self{};
  BrickNeighborhood Neighborhood;
  std::array<NumberedRows, 27> Neighbors{}; ///< rows of the neighbours, filled on first use
  /// Owners by axis and places; see BrickNeighborhood::FindOwner.
  std::array<std::array<std::array<BrickNeighborhood::Step, 3>, 3>, 3> Owners;

  RowSlab Slab{};
  std::array<Rows, 2> X; ///< [plane even or odd]
  std::array<Rows, 2> Y;
  std::array<Rows, 2> Z;
  std::array<std::array<Column, 2>, 2> ColumnY{}; ///< [column][plane even or odd]
  std::array<Column, 2> ColumnZ{};                ///< [column]
  std::array<int, 2> Filled{ -1, -1 };            ///< the planes that X, Y and Z hold
};

} // namespace isosurface

#endif
