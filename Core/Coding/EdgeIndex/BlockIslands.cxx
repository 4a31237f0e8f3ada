// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/BlockIslands.h"

#include "Coding/EdgeIndex/SingleBlock.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Islands/IslandKeeping.h"
#include "Surface/Islands/IslandLabels.h"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace isosurface
{

ContourRequest MakeContourRequest(const EdgeIndexHeader& header)
{
  ContourRequest request;
  request.Isovalues = header.Isovalues;
  request.GlobalIds = true;
  request.ClosedSides = header.ClosedSides;
  request.DropDegenerateTriangles = !header.ClosedSides.IsEmpty();
  return request;
}

void ShiftIds(const EdgeIndexHeader& header, std::size_t isovalue, Buffer<std::int64_t>& ids)
{
  const std::int64_t vertices =
    GetNumberedGrid(header.Geometry, MakeContourRequest(header)).GetNumberOfVertices();
  const auto number = static_cast<std::int64_t>(isovalue);
  const auto others = static_cast<std::int64_t>(header.Isovalues.size()) - 1;
  for (std::int64_t& id : ids)
  {
    id += id < 3 * vertices ? number * 3 * vertices : (3 * others + number) * vertices;
  }
}

Result<Surface> ExtractBlockSurface(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue)
{
  ContourRequest request = MakeContourRequest(header);
  request.Isovalues.assign(1, header.Isovalues[isovalue]);
  BlockSamples scalars = samples;
  scalars.Attributes.clear();
  SingleBlock source(scalars);
  ISOSURFACE_ASSIGN_OR_RETURN(Surface surface, ExtractSurface(header.Geometry, source, request, 1));
  ShiftIds(header, isovalue, surface.GlobalIds);
  return surface;
}

Result<std::vector<BlockIsland>> FindBlockIslands(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const Surface surface, ExtractBlockSurface(header, samples, isovalue));
  const IslandLabels labels(surface, 1);
  std::vector<BlockIsland> islands(
    labels.GetNumberOfIslands(), { std::numeric_limits<std::int64_t>::max() });
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    BlockIsland& island = islands[labels[point]];
    island.FirstId = std::min(island.FirstId, surface.GlobalIds[point]);
    ++island.Points;
  }
  std::sort(islands.begin(), islands.end(),
    [](const BlockIsland& a, const BlockIsland& b) { return a.FirstId < b.FirstId; });
  return islands;
}

Status KeepBlockIslands(const std::vector<BlockIsland>& told, int threads, Surface& surface)
{
  const Status corrupt(StatusCode::Corrupt,
    "The edge-index stream is corrupt: its blocks keep and leave out parts of one island.");
  if (told.empty())
  {
    return Status::Ok();
  }
  std::unordered_map<std::int64_t, bool> areKept;
  for (const BlockIsland& island : told)
  {
    if (areKept.emplace(island.FirstId, island.IsKept).first->second != island.IsKept)
    {
      return corrupt;
    }
  }
  const IslandLabels labels(surface, threads);
  constexpr std::uint8_t unknown = 2;
  std::vector<std::uint8_t> kept(labels.GetNumberOfIslands(), unknown);
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    const auto found = areKept.find(surface.GlobalIds[point]);
    if (found != areKept.end())
    {
      std::uint8_t& own = kept[labels[point]];
      const std::uint8_t isKept = found->second ? 1 : 0;
      if (own != unknown && own != isKept)
      {
        return corrupt;
      }
      own = isKept;
    }
  }
  KeepIslands(labels, kept, threads, surface);
  return Status::Ok();
}

} // namespace isosurface
