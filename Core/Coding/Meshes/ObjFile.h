// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ObjFile_h
#define isosurface_ObjFile_h

#include "Coding/Meshes/MeshFile.h"

namespace isosurface
{

/// Wavefront OBJ, as text: points with their normals, each once, and triangles, in a group for each
/// isovalue.
class ObjFile : public MeshFile
{
public:
  static std::uint64_t EstimateBytes(const Settings& settings);
  static Result<std::unique_ptr<MeshFile>> Create(
    std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings);

  Status Append(const Mesh& mesh, const PointNumbers& numbers) override;
  Status Finish() override { return this->File->SyncAndClose(); }

private:
  ObjFile(std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, bool hasNormals)
    : File(std::move(file))
    , Header(header)
    , HasNormals(hasNormals)
  {
  }

  Status WriteIfMany(std::string& text);

  std::unique_ptr<WritableFile> File;
  const EdgeIndexHeader& Header;
  bool HasNormals;
};

} // namespace isosurface

#endif
