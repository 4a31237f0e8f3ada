// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/RelevantVertices.h"

#include <algorithm>

namespace isosurface
{
namespace
{

// The ends of crossed edges within a slice, in row y. vertices, edges: those of a row.
SignRow FindWithin(
  const SignSlice& slice, int y, int sizeY, const SignRow& vertices, const SignRow& edges)
{
  const SignRow& row = slice.At(y);
  const SignRow alongX = (row ^ row.ShiftDown()) & edges;
  SignRow found = alongX | alongX.ShiftUp();
  if (y > 0)
  {
    found = found | (row ^ slice.At(y - 1));
  }
  if (y + 1 < sizeY)
  {
    found = found | (row ^ slice.At(y + 1));
  }
  return found & vertices;
}

} // namespace

void FindRelevant(const SignSlice& slice, const SignSlice* below, const SignSlice* above, int sizeX,
  int sizeY, bool near, RelevantSlice& relevant)
{
  const SignRow vertices = SignRow::MakeMask(sizeX);
  const SignRow edges = SignRow::MakeMask(sizeX - 1);
  std::array<SignRow, MaximumCodedVertices> withinAbove;
  relevant.IsEmpty = true;
  for (int y = 0; y < sizeY; ++y)
  {
    const auto n = static_cast<std::size_t>(y);
    SignRow found = FindWithin(slice, y, sizeY, vertices, edges);
    for (const SignSlice* beside : { below, above })
    {
      if (beside)
      {
        found = found | ((slice.At(y) ^ beside->At(y)) & vertices);
      }
    }
    withinAbove[n] = above && near ? FindWithin(*above, y, sizeY, vertices, edges) : SignRow();
    relevant.Relevant[n] = found;
    relevant.IsEmpty = relevant.IsEmpty && found.IsZero();
  }
  for (int y = 0; near && y < sizeY; ++y)
  {
    SignRow around;
    for (int other = std::max(0, y - 1); other < std::min(sizeY, y + 2); ++other)
    {
      const auto n = static_cast<std::size_t>(other);
      around = around | relevant.Relevant[n] | withinAbove[n];
    }
    relevant.Near[static_cast<std::size_t>(y)] =
      (around | around.ShiftUp() | around.ShiftDown()) & vertices;
  }
}

} // namespace isosurface
