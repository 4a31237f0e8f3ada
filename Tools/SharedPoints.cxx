// SPDX-License-Identifier: BSD-3-Clause
#include "SharedPoints.h"

#include <utility>

namespace isosurface
{
namespace
{

/// Which edge of the grid, or in a closed surface which vertex, a global id names; see ExtractSurface.
struct GridEdge
{
  Index3 Vertex;
  std::size_t Axis;

  GridEdge(std::int64_t id, const Index3& dimensions, std::int64_t closed)
    : Axis(static_cast<std::size_t>(id % 3))
  {
    const std::int64_t layer = closed > 0 ? 1 : 0;
    const Index3 size = { dimensions[0] + 2 * layer, dimensions[1] + 2 * layer,
      dimensions[2] + 2 * layer };
    const std::int64_t vertices = size[0] * size[1] * size[2];
    const bool isVertex = closed > 0 && id >= 3 * closed * vertices;
    this->Axis = isVertex ? 3 : this->Axis;
    const std::int64_t vertex = (isVertex ? id : id / 3) % vertices;
    this->Vertex = { vertex % size[0] - layer, vertex / size[0] % size[1] - layer,
      vertex / (size[0] * size[1]) - layer };
  }

  bool IsInPlane(std::size_t axis, std::int64_t place) const
  {
    return this->Axis != axis && this->Vertex[axis] == place;
  }
};

} // namespace

void SharedPoints::Begin(const SurfacePiece& piece)
{
  this->Box = piece.Box;
  this->Row = std::exchange(this->NextRow, {});
  if (piece.BeginsLayer)
  {
    this->Layer = std::exchange(this->NextLayer, {});
    this->Row.clear();
  }
}

PointNumbers SharedPoints::Number(const Mesh& mesh)
{
  PointNumbers numbers{ std::vector<std::uint64_t>(mesh.NumberOfPoints), this->NumberOfPoints };
  for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
  {
    const std::int64_t id = mesh.GlobalIds[point];
    const GridEdge edge(id, this->Dimensions, this->Closed);
    std::uint64_t number = this->NumberOfPoints;
    const auto find = [&](const Numbers& known)
    {
      const auto found = known.find(id);
      number = found == known.end() ? number : found->second;
    };
    if (edge.IsInPlane(2, this->Box.Low[2]))
    {
      find(this->Layer);
    }
    if (edge.IsInPlane(1, this->Box.Low[1]))
    {
      find(this->Row);
    }
    this->NumberOfPoints += number == this->NumberOfPoints ? 1 : 0;
    numbers.Values[point] = number;
    if (edge.IsInPlane(2, this->Box.High[2] - 1))
    {
      this->NextLayer[id] = number;
    }
    if (edge.IsInPlane(1, this->Box.High[1] - 1))
    {
      this->NextRow[id] = number;
    }
  }
  return numbers;
}

} // namespace isosurface
