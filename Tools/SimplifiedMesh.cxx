// SPDX-License-Identifier: BSD-3-Clause
#include "SimplifiedMesh.h"

#include <meshoptimizer.h>

#include <cmath>
#include <limits>

namespace isosurface
{
namespace
{

std::vector<std::uint32_t> ListNumbers(const Mesh& mesh)
{
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * mesh.NumberOfTriangles);
  for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
  {
    const std::uint32_t* corner = mesh.Corners + 3 * triangle;
    bool areNumbers = true;
    for (std::size_t value = 0; value < 9; ++value)
    {
      areNumbers =
        areNumbers && std::isfinite(mesh.Points[std::size_t{ 3 } * corner[value / 3] + value % 3]);
    }
    if (areNumbers)
    {
      corners.insert(corners.end(), corner, corner + 3);
    }
  }
  return corners;
}

/// The points with 0 for what is not a number: no triangle uses them, but all are looked at.
std::vector<float> ListFinitePoints(const Mesh& mesh)
{
  std::vector<float> points(mesh.Points, mesh.Points + 3 * mesh.NumberOfPoints);
  for (float& value : points)
  {
    value = std::isfinite(value) ? value : 0.0F;
  }
  return points;
}

} // namespace

SimplifiedMesh::SimplifiedMesh(const Mesh& mesh, std::size_t triangles)
  : Description(mesh)
  , Points(ListFinitePoints(mesh))
  , Corners(ListNumbers(mesh))
{
  if (3 * triangles < this->Corners.size())
  {
    // Where samples equal the isovalue, several points are in one place.
    std::vector<std::uint32_t> all(this->Corners.size());
    meshopt_generateShadowIndexBuffer(all.data(), this->Corners.data(), all.size(),
      this->Points.data(), mesh.NumberOfPoints, 3 * sizeof(float), 3 * sizeof(float));
    this->Corners.resize(meshopt_simplify(this->Corners.data(), all.data(), all.size(),
      this->Points.data(), mesh.NumberOfPoints, 3 * sizeof(float), 3 * triangles,
      std::numeric_limits<float>::max(), meshopt_SimplifyLockBorder, nullptr));
  }
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
      this->Points[std::size_t{ 3 } * kept + axis] = this->Points[3 * point + axis];
      if (mesh.Normals)
      {
        this->Normals.push_back(mesh.Normals[3 * point + axis]);
      }
    }
    this->GlobalIds.push_back(mesh.GlobalIds[point]);
    places[point] = kept++;
  }
  this->Points.resize(std::size_t{ 3 } * kept);
  for (std::uint32_t& corner : this->Corners)
  {
    corner = places[corner];
  }
}

Mesh SimplifiedMesh::Get() const
{
  Mesh mesh = this->Description;
  mesh.Points = this->Points.data();
  mesh.Normals = this->Description.Normals ? this->Normals.data() : nullptr;
  mesh.GlobalIds = this->GlobalIds.data();
  mesh.NumberOfPoints = this->GlobalIds.size();
  mesh.Corners = this->Corners.data();
  mesh.NumberOfTriangles = this->Corners.size() / 3;
  return mesh;
}

} // namespace isosurface
