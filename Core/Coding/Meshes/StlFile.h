// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StlFile_h
#define isosurface_StlFile_h

#include "Coding/Meshes/MeshFile.h"

namespace isosurface
{

/// Binary STL: a text of 80 bytes, the number of triangles, and 50 bytes for each, with its normal.
class StlFile : public MeshFile
{
public:
  static constexpr std::size_t TriangleSize = 50;

  static Result<std::unique_ptr<MeshFile>> Create(
    std::unique_ptr<WritableFile> file, const Settings& settings);

  Status Append(const Mesh& mesh, const PointNumbers& numbers) override;
  Status Finish() override;

private:
  explicit StlFile(std::unique_ptr<WritableFile> file)
    : File(std::move(file))
  {
  }

  std::unique_ptr<WritableFile> File;
  std::uint64_t NumberOfTriangles = 0;
};

} // namespace isosurface

#endif
