// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CellVisibility_h
#define isosurface_CellVisibility_h

#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridSides.h"
#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/BrickLattice.h"

#include <cstdint>

namespace isosurface
{

/**
 * The cells of a block that have a surface, where some have none: hidden ones (Blanking), and with
 * `skipNotANumber` those with a corner that is NaN. A sample is known if it is not NaN and belongs
 * to a visible cell; gradients are made of known samples alone.
 */
class CellVisibility
{
public:
  CellVisibility(const BlockSamples& samples, bool skipNotANumber);

  /// Whether this has anything to tell: if not, all cells are visible.
  bool IsLimited() const { return this->Hidden || this->SkipsNotANumber; }

  /**
   * Sets a word for each row of vertices, as BrickSurface::Inside has it: the bits of the visible
   * cells from that row on. False, and no words, if all cells of the brick are visible.
   */
  bool FindVisibleCells(const Brick& brick, std::uint64_t* visible) const;

  /// Whether a layer around the brick has samples that are not known, or the brick itself.
  bool HasUnknownSamples(const Brick& brick, const VertexBox& knownSamples) const;

  bool IsKnown(const Index3& vertex) const;

private:
  bool IsNotANumber(const Index3& vertex) const;
  bool IsCellVisible(const Index3& cell) const;
  /// The bits of the vertices of a row that are neither hidden nor NaN.
  std::uint64_t FindRow(const Index3& first, int count) const;
  /// The bits of the cells of a row that are not hidden themselves.
  std::uint64_t FindCellRow(const Index3& first, int count) const;
  void FindInnerCells(const Brick& brick, std::uint64_t* visible) const;
  void FindCellsBeyond(const Brick& brick, std::uint64_t* visible) const;

  const SampleView& Scalars;
  const Blanking* Hidden;
  bool SkipsNotANumber;
};

/// The triangles and polygons of the visible cells of a brick.
BrickCounts CountVisible(
  const int size[3], const std::uint64_t* inside, const std::uint64_t* visible);

/**
 * Makes the normals anew of those points whose gradients use samples that are not known: with
 * one-sided differences, or none, instead. `knownSamples` is the box beyond which there are none.
 */
void CorrectNormals(const CellVisibility& visibility, const SampleView& scalars,
  const VertexBox& knownSamples, const Index3& low, const EdgeCode* codes, const double* parameters,
  std::uint32_t count, float* normals);

} // namespace isosurface

#endif
