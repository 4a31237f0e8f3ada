// SPDX-License-Identifier: BSD-3-Clause
#include "CompressedMesh.h"

#include <meshoptimizer.h>

#include <algorithm>

namespace isosurface
{
namespace
{

/// Points that no triangle uses have this number.
constexpr std::uint32_t Unused = ~std::uint32_t{ 0 };

std::vector<std::uint8_t> EncodeNormals(
  const float* normals, const std::vector<std::uint32_t>& places, std::size_t count)
{
  std::vector<float> ordered(4 * count);
  for (std::size_t point = 0; point < places.size(); ++point)
  {
    if (places[point] != Unused)
    {
      std::copy_n(normals + 3 * point, 3, ordered.data() + std::size_t{ 4 } * places[point]);
    }
  }
  std::vector<std::uint8_t> octahedral(4 * count);
  meshopt_encodeFilterOct(octahedral.data(), count, 4, 8, ordered.data());
  return octahedral;
}

CompressibleMesh OrderForCompression(const Mesh& mesh)
{
  const std::size_t corners = 3 * mesh.NumberOfTriangles;
  CompressibleMesh ordered;
  ordered.Corners.resize(corners);
  meshopt_optimizeVertexCache(ordered.Corners.data(), mesh.Corners, corners, mesh.NumberOfPoints);
  std::vector<std::uint32_t> places(mesh.NumberOfPoints);
  const std::size_t points = meshopt_optimizeVertexFetchRemap(
    places.data(), ordered.Corners.data(), corners, mesh.NumberOfPoints);
  meshopt_remapIndexBuffer(ordered.Corners.data(), ordered.Corners.data(), corners, places.data());
  ordered.Points.resize(3 * points);
  meshopt_remapVertexBuffer(
    ordered.Points.data(), mesh.Points, mesh.NumberOfPoints, 3 * sizeof(float), places.data());
  if (mesh.Normals)
  {
    ordered.OctahedralNormals = EncodeNormals(mesh.Normals, places, points);
  }
  return ordered;
}

std::vector<std::uint8_t> EncodeTriangles(const std::uint32_t* corners, std::size_t count)
{
  // The extension has these versions of the codecs.
  meshopt_encodeIndexVersion(1);
  const std::size_t points = count == 0 ? 0 : *std::max_element(corners, corners + count) + 1;
  std::vector<std::uint8_t> code(meshopt_encodeIndexBufferBound(count, points));
  code.resize(meshopt_encodeIndexBuffer(code.data(), code.size(), corners, count));
  return code;
}

std::vector<std::uint8_t> EncodeVertices(const void* values, std::size_t count, std::size_t stride)
{
  meshopt_encodeVertexVersion(0);
  std::vector<std::uint8_t> code(meshopt_encodeVertexBufferBound(count, stride));
  code.resize(meshopt_encodeVertexBuffer(code.data(), code.size(), values, count, stride));
  return code;
}

} // namespace

const MeshCompression MeshoptimizerCompression = { OrderForCompression, EncodeTriangles,
  EncodeVertices };

} // namespace isosurface
