// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/PieceOwnership.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// Cuts a box into `count` parts across its longest axis; returns part `index`.
VertexBox TakePart(const VertexBox& box, std::int64_t index, std::int64_t count)
{
  const Index3 size = box.GetSize();
  std::size_t axis = 2;
  for (const std::size_t other : { std::size_t{ 1 }, std::size_t{ 0 } })
  {
    axis = size[other] > size[axis] ? other : axis;
  }
  VertexBox part = box;
  part.Low[axis] = box.Low[axis] + size[axis] * index / count;
  part.High[axis] = box.Low[axis] + size[axis] * (index + 1) / count;
  return part;
}

} // namespace

std::vector<VertexBox> SubtractBox(const VertexBox& box, const VertexBox& hole)
{
  const VertexBox common = box.Intersect(hole);
  if (common.IsEmpty())
  {
    return { box };
  }
  // The slabs below and above the hole on z; then those of what remains on y; then on x.
  std::vector<VertexBox> rest;
  VertexBox remaining = box;
  for (std::size_t axis = 3; axis-- > 0;)
  {
    VertexBox below = remaining;
    below.High[axis] = common.Low[axis];
    VertexBox above = remaining;
    above.Low[axis] = common.High[axis];
    for (const VertexBox& slab : { below, above })
    {
      if (!slab.IsEmpty())
      {
        rest.push_back(slab);
      }
    }
    remaining.Low[axis] = common.Low[axis];
    remaining.High[axis] = common.High[axis];
  }
  return rest;
}

std::vector<VertexBox> SubtractBox(const std::vector<VertexBox>& boxes, const VertexBox& hole)
{
  std::vector<VertexBox> rest;
  for (const VertexBox& box : boxes)
  {
    const std::vector<VertexBox> parts = SubtractBox(box, hole);
    rest.insert(rest.end(), parts.begin(), parts.end());
  }
  return rest;
}

std::vector<Supply> FindSupplies(
  const std::vector<VertexBox>& pieces, std::vector<VertexBox>& missing)
{
  std::vector<Supply> supplies;
  for (std::size_t piece = 0; piece < pieces.size() && !missing.empty(); ++piece)
  {
    const std::size_t before = supplies.size();
    for (const VertexBox& rest : missing)
    {
      const VertexBox part = rest.Intersect(pieces[piece]);
      if (!part.IsEmpty())
      {
        supplies.push_back({ piece, part });
      }
    }
    if (supplies.size() > before)
    {
      missing = SubtractBox(missing, pieces[piece]);
    }
  }
  return supplies;
}

std::vector<VertexBox> FindOwnedBoxes(const std::vector<VertexBox>& pieces, std::size_t rank)
{
  const VertexBox& mine = pieces[rank];
  if (mine.IsEmpty())
  {
    return {};
  }
  const auto first =
    static_cast<std::size_t>(std::find(pieces.begin(), pieces.end(), mine) - pieces.begin());
  const std::int64_t holders = std::count(pieces.begin(), pieces.end(), mine);
  const std::int64_t before =
    std::count(pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(rank), mine);
  std::vector<VertexBox> owned = { mine };
  for (std::size_t other = 0; other < first; ++other)
  {
    owned = SubtractBox(owned, pieces[other]);
  }
  std::vector<VertexBox> parts;
  for (const VertexBox& box : owned)
  {
    const VertexBox part = TakePart(box, before, holders);
    if (!part.IsEmpty())
    {
      parts.push_back(part);
    }
  }
  return parts;
}

} // namespace isosurface
