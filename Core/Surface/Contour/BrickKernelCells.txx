// SPDX-License-Identifier: BSD-3-Clause
// Triangles and polygons. A part of BrickKernel.txx.
#ifndef isosurface_BrickKernelCells_txx
#define isosurface_BrickKernelCells_txx

#include "Surface/Contour/BrickKernelRows.txx"

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{
namespace
{

template <typename Id>
inline Id NumberOf(const EdgeRow& row, Word below)
{
  return static_cast<Id>(row.First) + static_cast<Id>(CountBits(row.Bits & below));
}

// The numbers of the points on the twelve edges of cell (i, j); undefined for edges not crossed.
template <typename Id>
inline void NumberEdges(const RowSlab& slab, int i, int j, Id numbers[12])
{
  const Word below = MaskBelow(i);
  const Word upTo = below << 1 | 1;
  numbers[0] = NumberOf<Id>(slab.X[0][j], below);
  numbers[1] = NumberOf<Id>(slab.X[0][j + 1], below);
  numbers[2] = NumberOf<Id>(slab.X[1][j], below);
  numbers[3] = NumberOf<Id>(slab.X[1][j + 1], below);
  numbers[4] = NumberOf<Id>(slab.Y[0][j], below);
  numbers[5] = NumberOf<Id>(slab.Y[0][j], upTo);
  numbers[6] = NumberOf<Id>(slab.Y[1][j], below);
  numbers[7] = NumberOf<Id>(slab.Y[1][j], upTo);
  numbers[8] = NumberOf<Id>(slab.Z[j], below);
  numbers[9] = NumberOf<Id>(slab.Z[j], upTo);
  numbers[10] = NumberOf<Id>(slab.Z[j + 1], below);
  numbers[11] = NumberOf<Id>(slab.Z[j + 1], upTo);
}

// Replaces the numbers of edges on a cell's low (side 0) or high (side 1) x face by those of the
// column.
template <typename Id>
inline void NumberColumnEdges(const RowSlab& slab, int side, int j, Id numbers[12])
{
  numbers[4 + side] = static_cast<Id>(slab.ColumnY[side][0][j]);
  numbers[6 + side] = static_cast<Id>(slab.ColumnY[side][1][j]);
  numbers[8 + side] = static_cast<Id>(slab.ColumnZ[side][j]);
  numbers[10 + side] = static_cast<Id>(slab.ColumnZ[side][j + 1]);
}

constexpr int MaximumCorners = 15;

template <typename Id>
inline Id* AppendTriangles(Id* out, const Id* end, Word triangles, const Id numbers[12])
{
  const int corners = 3 * static_cast<int>(triangles >> 60);
  if (end - out >= MaximumCorners)
  {
    // Usually there are two triangles. They are always written, which saves a branch misprediction.
    for (int n = 0; n < 6; ++n)
    {
      out[n] = numbers[triangles >> (4 * n) & 15];
    }
    if (corners > 6)
    {
      for (int n = 6; n < MaximumCorners; ++n)
      {
        // Unused nibbles are 0, which is a valid edge.
        out[n] = numbers[triangles >> (4 * n) & 15];
      }
    }
    return out + corners;
  }
  for (int n = 0; n < corners; ++n)
  {
    out[n] = numbers[triangles >> (4 * n) & 15];
  }
  return out + corners;
}

// Calls forCell(case, numbers) for every cell of the slab that the surface crosses.
template <typename Id, typename Functor>
inline void VisitCells(const RowSlab& slab, const Functor& forCell)
{
  const int lastCell = slab.Size[0] - 2;
  const Word cells = MaskBelow(slab.Size[0] - 1);
  for (int j = 0; j + 1 < slab.Size[1]; ++j)
  {
    const Word row00 = slab.Inside[0][j];
    const Word row10 = slab.Inside[0][j + 1];
    const Word row01 = slab.Inside[1][j];
    const Word row11 = slab.Inside[1][j + 1];
    const Word visible = slab.Visible ? cells & slab.Visible[j] : cells;
    Id numbers[12];
    for (Word active = ActiveCells(row00, row10, row01, row11, visible); active != 0;
         active &= active - 1)
    {
      const int i = FindFirstBit(active);
      NumberEdges(slab, i, j, numbers);
      if (i == lastCell)
      {
        NumberColumnEdges(slab, 1, j, numbers);
      }
      if (i == 0 && !slab.FirstColumnInRow)
      {
        NumberColumnEdges(slab, 0, j, numbers);
      }
      forCell(CaseOf(i, row00, row10, row01, row11), numbers);
    }
  }
}

template <typename Id>
Id* WriteTriangles(const RowSlab& slab, Id* out, Id* end)
{
  VisitCells<Id>(slab,
    [&](unsigned cellCase, const Id numbers[12])
    { out = AppendTriangles(out, end, slab.Cases.Triangles[cellCase], numbers); });
  return out;
}

template <typename Id>
void WritePolygons(const RowSlab& slab, Id*& connectivity, Id*& offsets, std::int64_t& index)
{
  VisitCells<Id>(slab,
    [&](unsigned cellCase, const Id numbers[12])
    {
      const PolygonCase& polygons = slab.Cases.Polygons[cellCase];
      for (int polygon = 0; polygon < polygons.NumberOfPolygons; ++polygon)
      {
        *offsets++ = static_cast<Id>(index);
        index += polygons.Sizes[polygon];
      }
      for (int corner = 0; corner < polygons.NumberOfCorners; ++corner)
      {
        *connectivity++ = numbers[polygons.Corners[corner]];
      }
    });
}

} // namespace
} // namespace ISOSURFACE_KERNEL
} // namespace isosurface

#endif
