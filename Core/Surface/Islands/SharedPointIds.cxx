// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Islands/SharedPointIds.h"

#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Islands/SurfaceRanges.h"

#include <algorithm>

namespace isosurface
{

SharedPlanes::SharedPlanes(
  const GridGeometry& grid, const ContourRequest& request, std::int64_t firstId)
  : FirstId(firstId)
{
  const GridGeometry numbered = GetNumberedGrid(grid, request);
  this->Dimensions = numbered.GetDimensions();
  this->Shift = grid.Extent[0] - numbered.Extent[0];
  this->NumberOfVertices = numbered.GetNumberOfVertices();
  this->NumberOfIsovalues = request.Isovalues.size();
  this->NumberOfEdgeIds =
    3 * this->NumberOfVertices * static_cast<std::int64_t>(request.Isovalues.size());
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->AreShared[axis].resize(static_cast<std::size_t>(this->Dimensions[axis]), 0);
  }
}

std::size_t SharedPlanes::FindIsovalue(std::int64_t id) const
{
  const std::int64_t own = id - this->FirstId;
  const std::int64_t vertex = own >= this->NumberOfEdgeIds ? own - this->NumberOfEdgeIds : own / 3;
  return static_cast<std::size_t>(vertex / this->NumberOfVertices);
}

void SharedPlanes::Add(std::size_t axis, std::int64_t vertex)
{
  std::uint8_t& isShared = this->AreShared[axis][static_cast<std::size_t>(vertex + this->Shift)];
  this->Planes += isShared == 0 ? 1 : 0;
  isShared = 1;
}

void SharedPlanes::AddFacesOfBlocks(std::int64_t blockSize)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t vertices = this->Dimensions[axis] - 2 * this->Shift;
    for (std::int64_t vertex = blockSize; vertex + 1 < vertices; vertex += blockSize)
    {
      this->Add(axis, vertex);
    }
  }
}

bool SharedPlanes::Finder::IsInPlane(std::int64_t id)
{
  const SharedPlanes& grid = this->Shared;
  const std::int64_t own = id - grid.FirstId;
  const bool isOnVertex = own >= grid.NumberOfEdgeIds;
  const std::int64_t axis = isOnVertex ? 3 : own % 3;
  std::int64_t vertex = isOnVertex ? own - grid.NumberOfEdgeIds : own / 3;
  if (vertex >= grid.NumberOfVertices)
  {
    vertex %= grid.NumberOfVertices; // of another isovalue than the first
  }
  if (vertex < this->RowBegin || vertex >= this->RowEnd)
  {
    const std::int64_t row = vertex / grid.Dimensions[0];
    this->RowBegin = row * grid.Dimensions[0];
    this->RowEnd = this->RowBegin + grid.Dimensions[0];
    this->IsRowShared[0] =
      grid.AreShared[1][static_cast<std::size_t>(row % grid.Dimensions[1])] != 0;
    this->IsRowShared[1] =
      grid.AreShared[2][static_cast<std::size_t>(row / grid.Dimensions[1])] != 0;
  }
  // An edge lies in the planes of the other axes alone.
  return (axis != 1 && this->IsRowShared[0]) || (axis != 2 && this->IsRowShared[1]) ||
    (axis != 0 && grid.AreShared[0][static_cast<std::size_t>(vertex - this->RowBegin)] != 0);
}

std::vector<SharedPoint> FindSharedPoints(const Surface& surface, const IslandLabels& labels,
  const std::vector<SharedPlanes>& grids, int threads)
{
  const bool isNone = std::all_of(
    grids.begin(), grids.end(), [](const SharedPlanes& planes) { return planes.IsEmpty(); });
  if (isNone)
  {
    return {};
  }
  std::vector<std::vector<SharedPoint>> found(CountRanges(surface.NumberOfPoints));
  ForRanges(surface.NumberOfPoints, threads,
    [&](std::size_t begin, std::size_t end, std::size_t range)
    {
      std::vector<SharedPlanes::Finder> finders(grids.begin(), grids.end());
      for (std::size_t point = begin; point < end; ++point)
      {
        const std::int64_t id = surface.GlobalIds[point];
        const auto grid = std::upper_bound(grids.begin() + 1, grids.end(), id,
          [](std::int64_t value, const SharedPlanes& planes)
          { return value < planes.GetFirstId(); });
        if (finders[static_cast<std::size_t>(grid - grids.begin() - 1)].IsInPlane(id))
        {
          found[range].push_back({ id, labels[point] });
        }
      }
    });
  std::vector<SharedPoint> all;
  for (std::vector<SharedPoint>& part : found)
  {
    all.insert(all.end(), part.begin(), part.end());
    part = {};
  }
  return all;
}

} // namespace isosurface
