// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridUnion.h"

#include <algorithm>
#include <cstring>
#include <tuple>
#include <type_traits>

namespace isosurface
{
namespace
{

// What makes two pieces those of one grid; also the order of the grids.
auto GetFrame(const GridGeometry& grid)
{
  return std::tie(grid.Origin, grid.Spacing, grid.Direction);
}

} // namespace

Message PackGrids(const std::vector<GridGeometry>& pieces)
{
  static_assert(std::is_trivially_copyable_v<GridGeometry>, "grids travel as bytes");
  const auto* from = reinterpret_cast<const std::uint8_t*>(pieces.data());
  return Message(from, from + pieces.size() * sizeof(GridGeometry));
}

std::vector<GridGeometry> UniteGrids(const std::vector<Message>& packed)
{
  std::vector<GridGeometry> all;
  for (const Message& message : packed)
  {
    for (std::size_t at = 0; at + sizeof(GridGeometry) <= message.size();
         at += sizeof(GridGeometry))
    {
      std::memcpy(&all.emplace_back(), &message[at], sizeof(GridGeometry));
    }
  }
  std::stable_sort(all.begin(), all.end(),
    [](const GridGeometry& a, const GridGeometry& b) { return GetFrame(a) < GetFrame(b); });
  std::vector<GridGeometry> united;
  for (const GridGeometry& grid : all)
  {
    if (united.empty() || GetFrame(united.back()) != GetFrame(grid))
    {
      united.push_back(grid);
    }
    auto& extent = united.back().Extent;
    for (int axis = 0; axis < 3; ++axis)
    {
      extent[2 * axis] = std::min(extent[2 * axis], grid.Extent[2 * axis]);
      extent[2 * axis + 1] = std::max(extent[2 * axis + 1], grid.Extent[2 * axis + 1]);
    }
  }
  return united;
}

std::size_t FindGrid(const std::vector<GridGeometry>& grids, const GridGeometry& piece)
{
  const auto found = std::find_if(grids.begin(), grids.end(),
    [&](const GridGeometry& grid) { return GetFrame(grid) == GetFrame(piece); });
  return static_cast<std::size_t>(found - grids.begin());
}

} // namespace isosurface
