// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MeshWriteJob_h
#define isosurface_MeshWriteJob_h

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Ground/Base/Progress.h"
#include "Ground/Volume/Vector3.h"
#include "Coding/Meshes/MeshFile.h"
#include "SharedPoints.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Decodes an edge-index file piece by piece into a file of triangles.
class MeshWriteJob
{
public:
  struct Settings
  {
    std::uint64_t NumberOfTriangles = 0; ///< about the number to simplify to; 0: keep all
    std::uint64_t MemoryMebibytes = 1024;
    int Threads = 1;
    bool IsPreview = false;
    bool IsCompressed = false;
    double UnitInMetres = 0.001;        ///< the unit of the points; of .glb
    std::vector<std::size_t> Isovalues; ///< numbers of those to write; none: all
  };

  /// `file` must outlive the job.
  MeshWriteJob(const EdgeIndexFile& file, const Settings& settings);

  /// Writes the file that is to be at `path` at `partial`. Errors: those of EdgeIndexFile::Read() and
  /// MeshFile.
  Status Write(const std::string& path, const std::string& partial, const Progress& progress);

  /// From where the float32 points of .stl files count, if float32 does not suffice for places.
  const std::optional<Vector3>& GetOrigin() const { return this->Origin; }
  std::uint64_t GetNumberOfPoints() const { return this->Shared.GetNumberOfPoints(); }
  std::uint64_t GetNumberOfTriangles() const { return this->NumberOfTriangles; }
  /// Those with a point that is not finite.
  std::uint64_t GetNumberOfDroppedTriangles() const { return this->NumberOfDroppedTriangles; }

private:
  std::vector<SurfacePortion> FindPieces() const;
  Status WritePiece(const SurfacePortion& piece, MeshFile& output, const Progress& progress);
  /// Simplifies a mesh to about `triangles`, if it has more, and writes it.
  Status WritePart(const Mesh& mesh, std::size_t triangles, MeshFile& output);

  const EdgeIndexFile& File;
  Settings Chosen;
  bool HasNormals;
  std::optional<Vector3> Origin; ///< the first vertex of the grid, if points are float64
  std::uint64_t PointsInAll = 0; ///< as the directory counts them
  SharedPoints Shared;
  std::uint64_t NumberOfTriangles = 0;
  std::uint64_t NumberOfDroppedTriangles = 0;
};

} // namespace isosurface

#endif
