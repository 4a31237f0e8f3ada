// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PlyFile_h
#define isosurface_PlyFile_h

#include "Coding/Meshes/MeshFile.h"

namespace isosurface
{

/**
 * Binary PLY, little-endian: points with their normals, each once, then triangles. Triangles go to a
 * second file first, PATH.faces, which is appended at the end.
 */
class PlyFile : public MeshFile
{
public:
  static Result<std::unique_ptr<MeshFile>> Create(
    FileSystem& files, std::unique_ptr<WritableFile> file, const Settings& settings);

  ~PlyFile() override;
  Status Append(const Mesh& mesh, const PointNumbers& numbers) override;
  Status Finish() override;

private:
  PlyFile(FileSystem& files, std::unique_ptr<WritableFile> file,
    std::unique_ptr<WritableFile> faces, const Settings& settings)
    : Files(files)
    , File(std::move(file))
    , Faces(std::move(faces))
    , HasNormals(settings.HasNormals)
    , HasDoublePoints(settings.HasDoublePoints)
  {
  }

  std::string MakeHeader() const;
  Status AppendNewPoints(const Mesh& mesh, const PointNumbers& numbers);
  Status AppendTriangles(const Mesh& mesh, const PointNumbers& numbers);

  FileSystem& Files;
  std::unique_ptr<WritableFile> File;
  std::unique_ptr<WritableFile> Faces;
  bool HasNormals;
  bool HasDoublePoints;
  std::uint64_t NumberOfPoints = 0;
  std::uint64_t NumberOfTriangles = 0;
};

} // namespace isosurface

#endif
