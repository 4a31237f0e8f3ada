// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SimplifiedMesh_h
#define isosurface_SimplifiedMesh_h

#include "Coding/Meshes/MeshFile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A mesh of fewer triangles, which keeps points of the first one, its topology, and the points at open
/// sides, so that pieces still meet.
class SimplifiedMesh
{
public:
  /// `triangles`: the aim; there are more where open sides or the topology demand it.
  SimplifiedMesh(const Mesh& mesh, std::size_t triangles);

  /// Refers to arrays of this object.
  Mesh Get() const;

private:
  void KeepUsedPoints(const Mesh& mesh);

  Mesh Description;
  std::vector<float> Points;
  std::vector<double> DoublePoints; ///< if the first mesh has them
  std::vector<float> Normals;
  std::vector<std::int64_t> GlobalIds;
  std::vector<std::uint32_t> Corners;
};

} // namespace isosurface

#endif
