// SPDX-License-Identifier: BSD-3-Clause
#include "SimplifiedMesh.h"

#include "EdgeCollapse.h"

#include <limits>

namespace isosurface
{

SimplifiedMesh::SimplifiedMesh(const Mesh& mesh, std::size_t triangles)
  : Description(mesh)
  , Corners(mesh.Corners, mesh.Corners + 3 * mesh.NumberOfTriangles)
{
  CollapseEdges(mesh.Points, mesh.NumberOfPoints, triangles, this->Corners);
  this->KeepUsedPoints(mesh);
}

void SimplifiedMesh::KeepUsedPoints(const Mesh& mesh)
{
  constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> places(mesh.NumberOfPoints, unused);
  for (const std::uint32_t corner : this->Corners)
  {
    places[corner] = 0;
  }
  std::uint32_t kept = 0;
  for (std::size_t point = 0; point < places.size(); ++point)
  {
    if (places[point] == unused)
    {
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Points.push_back(mesh.Points[3 * point + axis]);
      if (mesh.DoublePoints)
      {
        this->DoublePoints.push_back(mesh.DoublePoints[3 * point + axis]);
      }
      if (mesh.Normals)
      {
        this->Normals.push_back(mesh.Normals[3 * point + axis]);
      }
    }
    this->GlobalIds.push_back(mesh.GlobalIds[point]);
    places[point] = kept++;
  }
  for (std::uint32_t& corner : this->Corners)
  {
    corner = places[corner];
  }
}

Mesh SimplifiedMesh::Get() const
{
  Mesh mesh = this->Description;
  mesh.Points = this->Points.data();
  mesh.DoublePoints = this->Description.DoublePoints ? this->DoublePoints.data() : nullptr;
  mesh.Normals = this->Description.Normals ? this->Normals.data() : nullptr;
  mesh.GlobalIds = this->GlobalIds.data();
  mesh.NumberOfPoints = this->GlobalIds.size();
  mesh.Corners = this->Corners.data();
  mesh.NumberOfTriangles = this->Corners.size() / 3;
  return mesh;
}

} // namespace isosurface
