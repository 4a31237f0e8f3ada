// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CompressedMesh_h
#define isosurface_CompressedMesh_h

#include "MeshFile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A mesh in the order in which meshoptimizer's codecs are good.
struct CompressibleMesh
{
  std::vector<float> Points;
  std::vector<std::uint8_t> OctahedralNormals; ///< 4 bytes a point; empty without normals
  std::vector<std::uint32_t> Corners;
};

/// The same triangles in another order, and the points that they use.
CompressibleMesh OrderForCompression(const Mesh& mesh);

/// The code of EXT_meshopt_compression for corners of triangles.
std::vector<std::uint8_t> EncodeTriangles(const std::uint32_t* corners, std::size_t count);
/// That for values of points, `stride` bytes each, a multiple of 4.
std::vector<std::uint8_t> EncodeVertices(const void* values, std::size_t count, std::size_t stride);

} // namespace isosurface

#endif
