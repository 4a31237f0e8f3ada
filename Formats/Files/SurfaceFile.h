// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceFile_h
#define isosurface_SurfaceFile_h

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Surface/Contour/InterpolatedArray.h"
#include "Surface/Contour/Surface.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// An edge-index file, whose surface is read. Functions may be called by several threads at once.
class SurfaceFile
{
public:
  /// Whether a file begins as an edge-index file does.
  static bool CanRead(const std::string& path);
  /// Errors and cost: EdgeIndexFile::Open.
  static Result<std::shared_ptr<SurfaceFile>> Open(const std::string& path);

  const std::string& GetPath() const { return this->File->GetPath(); }
  const EdgeIndexHeader& GetHeader() const { return this->File->GetHeader(); }
  /// EdgeIndexFile::GetMissing.
  const std::string& GetMissing() const { return this->File->GetMissing(); }
  std::uint64_t GetFingerprint() const { return this->File->GetFingerprint(); }
  /// The arrays on the points, normals left out.
  std::vector<InterpolatedArray> GetArrays() const;

  /// Normals are those of the file; if it has none, those of the triangles. A preview has no
  /// attributes. Of the request, GlobalIds, Offsets and WideIndices count.
  Result<Surface> Read(const EdgeIndexSelection& selection, ContourRequest request, bool normals,
    int threads, const Progress& progress) const;
  /// The vertices between which all cells lie that meet a box x0, x1, y0, y1, z0, z1 of the world.
  VertexBox FindVertices(const std::array<double, 6>& bounds) const;

private:
  explicit SurfaceFile(std::unique_ptr<EdgeIndexFile> file)
    : File(std::move(file))
  {
  }

  std::unique_ptr<EdgeIndexFile> File;
};

} // namespace isosurface

#endif
