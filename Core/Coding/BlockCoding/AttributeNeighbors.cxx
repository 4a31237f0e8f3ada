// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/AttributeNeighbors.h"

namespace isosurface
{
namespace
{

constexpr int MaximumSquaredQuarters = 6; ///< four times the squared distance of middles

// The row of edges along `other` near an edge along `axis`.
AttributeNeighbors::Row MakeRow(int axis, int plane, int dy, int other)
{
  AttributeNeighbors::Row row;
  row.Plane = static_cast<std::size_t>(plane);
  row.Axis = static_cast<std::size_t>(other);
  row.Y = dy;
  for (int dx = -2; dx <= 2; ++dx)
  {
    const int step[3] = { dx, dy, -plane };
    int quarters = 0;
    for (int n = 0; n < 3; ++n)
    {
      const int halves = 2 * step[n] - (n == axis ? 1 : 0) + (n == other ? 1 : 0);
      quarters += halves * halves;
    }
    if (quarters > 0 && quarters <= MaximumSquaredQuarters)
    {
      row.Near |= 1u << (dx + 2);
      row.Weights[static_cast<std::size_t>(dx + 2)] = 4096 / (quarters * quarters);
    }
  }
  return row;
}

} // namespace

const AttributeNeighbors& AttributeNeighbors::Get()
{
  static const AttributeNeighbors neighbors;
  return neighbors;
}

AttributeNeighbors::AttributeNeighbors()
{
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int plane = 0; plane < 2; ++plane)
    {
      for (int line = 0; line < 9; ++line)
      {
        const Row row = MakeRow(axis, plane, line / 3 - 1, line % 3);
        if (row.Near != 0)
        {
          this->Rows[static_cast<std::size_t>(axis)].push_back(row);
        }
      }
    }
  }
}

} // namespace isosurface
