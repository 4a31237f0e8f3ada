// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/ValueCoder.h"

namespace isosurface
{

ValueModel::ValueModel(bool mixed)
  : Residuals(mixed, Priors.Values)
  , MeanHeight(700 << 6)
  , MeanLevel(24 * 16)
{
  ApplyPriors(*this);
}

void FindRelevant(const SignSlice& slice, const SignSlice* below, const SignSlice* above, int sizeX,
  int sizeY, bool near, RelevantSlice& relevant)
{
  const SignRow vertices = SignRow::MakeMask(sizeX);
  const SignRow cells = SignRow::MakeMask(sizeX - 1);
  std::array<SignRow, MaximumCodedVertices> above1; // relevant by the edges within the slice above
  relevant.IsEmpty = true;
  const auto findWithin = [&](const SignSlice& of, int y)
  {
    const SignRow& row = of.At(y);
    const SignRow alongX = (row ^ row.ShiftDown()) & cells;
    SignRow found = alongX | alongX.ShiftUp();
    if (y > 0)
    {
      found = found | (row ^ of.At(y - 1));
    }
    if (y + 1 < sizeY)
    {
      found = found | (row ^ of.At(y + 1));
    }
    return found & vertices;
  };
  for (int y = 0; y < sizeY; ++y)
  {
    const auto n = static_cast<std::size_t>(y);
    SignRow found = findWithin(slice, y);
    if (below)
    {
      found = found | ((slice.At(y) ^ below->At(y)) & vertices);
    }
    above1[n] = SignRow();
    if (above)
    {
      found = found | ((slice.At(y) ^ above->At(y)) & vertices);
      if (near)
      {
        above1[n] = findWithin(*above, y);
      }
    }
    relevant.Relevant[n] = found;
    relevant.IsEmpty = relevant.IsEmpty && found.IsZero();
  }
  for (int y = 0; near && y < sizeY; ++y)
  {
    SignRow around;
    for (int other = std::max(0, y - 1); other < std::min(sizeY, y + 2); ++other)
    {
      const auto n = static_cast<std::size_t>(other);
      around = around | relevant.Relevant[n] | above1[n];
    }
    relevant.Near[static_cast<std::size_t>(y)] =
      (around | around.ShiftUp() | around.ShiftDown()) & vertices;
  }
}

} // namespace isosurface
