// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceMeshes_h
#define isosurface_SurfaceMeshes_h

#include "Coding/Meshes/MeshFile.h"
#include "Surface/Contour/Surface.h"

#include <functional>
#include <optional>

namespace isosurface
{

/// Calls visit(mesh) for each part of a surface that has triangles; Mesh::Isovalue is the number of the part.
/// `origin`: of float64 points. Ends with the first error.
Status VisitMeshes(const Surface& surface, const std::optional<Vector3>& origin, bool hasNormals,
  const std::function<Status(Mesh& mesh)>& visit);

/// Writes a surface as one file (MeshFile::Knows), in place of an older one when it is complete. Of the header the
/// isovalues and the name of the array count. Errors: InvalidArgument for another format, or if a point is not
/// finite; those of MeshFile.
Status SaveSurface(FileSystem& files, const Surface& surface, bool hasNormals,
  const EdgeIndexHeader& header, double unitInMetres, const std::string& path);

} // namespace isosurface

#endif
