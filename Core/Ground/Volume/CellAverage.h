// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CellAverage_h
#define isosurface_CellAverage_h

#include "Ground/Volume/Blanking.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/ValueType.h"

namespace isosurface
{

/// Tuples at the cells of a box of vertices, x fastest. An axis with one vertex has one layer of
/// cells.
struct CellTuples
{
  ValueType Type = ValueType::Float32;
  int NumberOfComponents = 1;
  const void* First = nullptr;
  VertexBox Box; ///< the vertices
};

/**
 * Tuples of the same type at some vertices of the box, x fastest: the mean of the visible cells
 * around each vertex, 0 where there are none. Integers are rounded to the nearest one. Bit for bit
 * what vtkCellDataToPointData makes of the same cells, so at the border of the box the mean is that
 * of the cells within. `hidden` has the same box.
 */
void AverageCells(const CellTuples& cells, const Blanking& hidden, const VertexBox& vertices,
  int threads, void* tuples);

} // namespace isosurface

#endif
