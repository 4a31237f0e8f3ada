// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MeshFile_h
#define isosurface_MeshFile_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/Vector3.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// The triangles of one isovalue in a piece of a surface. The arrays are the caller's. Points are
/// finite; normals may be of any length, and not numbers.
struct Mesh
{
  const float* Points = nullptr;           ///< x, y, z in the world, from MeshFile's Origin on
  const double* DoublePoints = nullptr;    ///< from 0 on, where float32 does not suffice; else null
  const float* Normals = nullptr;          ///< x, y, z; null for none
  const std::int64_t* GlobalIds = nullptr; ///< of the grid's edges on which the points are
  std::size_t NumberOfPoints = 0;
  const std::uint32_t* Corners = nullptr; ///< three numbers of points a triangle
  std::size_t NumberOfTriangles = 0;
  std::size_t Isovalue = 0; ///< its number in the header of the edge-index file
};

/// A mesh in an order in which its compression is good.
struct CompressibleMesh
{
  std::vector<float> Points;
  std::vector<std::uint8_t> OctahedralNormals; ///< 4 bytes a point; empty without normals
  std::vector<std::uint32_t> Corners;
};

/// How arrays are compressed (EXT_meshopt_compression), for a program that has a library for it.
struct MeshCompression
{
  /// The same triangles in another order, and the points that they use.
  CompressibleMesh (*Order)(const Mesh& mesh);
  /// The code for corners of triangles.
  std::vector<std::uint8_t> (*EncodeTriangles)(const std::uint32_t* corners, std::size_t count);
  /// That for values of points, `stride` bytes each, a multiple of 4.
  std::vector<std::uint8_t> (*EncodeVertices)(
    const void* values, std::size_t count, std::size_t stride);
};

/// The numbers in the whole surface of a mesh's points. Those from First on are new, and follow each
/// other in the order of the mesh.
struct PointNumbers
{
  std::vector<std::uint64_t> Values;
  std::uint64_t First = 0;
};

/// A place with the digits that tell it from all others.
std::string ToText(const Vector3& place);

/// A file of triangles that is written piece by piece, in little more memory than a piece has.
class MeshFile
{
public:
  struct Settings
  {
    std::string Path;                             ///< its end names the format
    std::string Partial;                          ///< where the file is written
    std::size_t MostMeshes = 0;                   ///< that will be appended
    bool HasNormals = false;                      ///< every mesh has them
    const MeshCompression* Compression = nullptr; ///< only of .glb; null: none
    double UnitInMetres = 0.001;                  ///< of the points; for .glb
    bool HasDoublePoints = false;                 ///< every mesh has them
    Vector3 Origin{};            ///< from which float32 points count; 0 unless there are others
    std::uint64_t Points = 0;    ///< about how many will be appended
    std::uint64_t Triangles = 0; ///< likewise
  };

  /// About the bytes that the file will have; a maximum if it is compressed.
  static std::uint64_t EstimateBytes(const Settings& settings);
  /// Unsupported if the format certainly has no room for the points and triangles of `settings`.
  static Status CheckLimits(const Settings& settings);
  /// A file of the format: .stl, .ply, .glb or .obj. `header` must outlive it.
  static Result<std::unique_ptr<MeshFile>> Create(
    FileSystem& files, const EdgeIndexHeader& header, const Settings& settings);
  /// Whether Create() knows the format.
  static bool Knows(const std::string& path);

  virtual ~MeshFile() = default;
  /// Errors: IoError, DiskFull; Unsupported if the format cannot hold as much.
  virtual Status Append(const Mesh& mesh, const PointNumbers& numbers) = 0;
  /// Writes what is known only at the end, then closes.
  virtual Status Finish() = 0;
};

} // namespace isosurface

#endif
