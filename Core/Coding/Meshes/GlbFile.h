// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GlbFile_h
#define isosurface_GlbFile_h

#include "Coding/Meshes/MeshFile.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace isosurface
{

/**
 * Binary glTF 2.0: a mesh for each isovalue, with a primitive for each piece. Points where pieces meet
 * are in both, with equal coordinates. The JSON chunk comes before the samples and is known at the
 * end: it has room that is filled with blanks.
 *
 * glTF is in metres, with y up. So a node turns the isovalues' nodes, whose z is up, and scales them
 * from the unit of the points. It also moves them from their origin. Normals get unit length; where there is none, they are those of the
 * triangles.
 *
 * Compressed (EXT_meshopt_compression, KHR_mesh_quantization): points are exact, normals have 8 bits
 * in an octahedron, triangles come in another order.
 */
class GlbFile : public MeshFile
{
public:
  static Result<std::unique_ptr<MeshFile>> Create(
    std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings);

  Status Append(const Mesh& mesh, const PointNumbers& numbers) override;
  Status Finish() override;

private:
  using Json = nlohmann::ordered_json;
  /// An array of the file, as a reader sees it.
  struct View
  {
    const void* Bytes = nullptr;
    std::size_t Count = 0;
    std::size_t Stride = 0;
    bool IsOfIndices = false;
    const char* Filter = nullptr; ///< of the compressed bytes
  };

  GlbFile(
    std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings);

  std::uint64_t GetBinaryBytes() const { return this->File->GetSize() - this->BinaryStart; }
  Status AppendPlain(const Mesh& mesh);
  Status AppendCompressed(const Mesh& mesh);
  /// Writes an array, and adds it to the JSON as a buffer view.
  Status AppendView(const View& view);
  Status AppendBytes(const void* bytes, std::size_t size);
  void AddAccessor(
    int componentType, std::size_t count, const char* type, bool isNormalized = false);
  /// Adds the accessor of points, with their bounds.
  void AddPoints(const float* points, std::size_t count);
  /// Adds the triangles of the last accessors to the mesh of an isovalue.
  void AddPrimitive(std::size_t isovalue);
  std::string MakeJson() const;

  std::unique_ptr<WritableFile> File;
  const EdgeIndexHeader& Header;
  bool HasNormals;
  const MeshCompression* Compression; ///< null: none
  double UnitInMetres;
  Vector3 Origin; ///< of the points
  std::size_t JsonBytes;
  std::uint64_t BinaryStart;
  std::uint64_t PlainBytes = 0; ///< of the views, if nothing were compressed
  Json Views = Json::array();
  Json Accessors = Json::array();
  std::vector<Json> Primitives; ///< of each isovalue
};

} // namespace isosurface

#endif
