// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SimplifiedMesh_h
#define isosurface_SimplifiedMesh_h

#include "MeshFile.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * A mesh of fewer triangles, which keeps points of the first one (meshoptimizer, quadric error
 * metric). Points at open sides stay, so that pieces still meet. Triangles with a point that is not a
 * number are left out.
 */
class SimplifiedMesh
{
public:
  /// `triangles`: the aim; there are more where open sides or the topology demand it. At least all of
  /// the mesh: only triangles that are not numbers, and points without triangles, are left out.
  SimplifiedMesh(const Mesh& mesh, std::size_t triangles);

  /// Refers to arrays of this object.
  Mesh Get() const;

private:
  void KeepUsedPoints(const Mesh& mesh);

  Mesh Description;
  std::vector<float> Points;
  std::vector<float> Normals;
  std::vector<std::int64_t> GlobalIds;
  std::vector<std::uint32_t> Corners;
};

} // namespace isosurface

#endif
