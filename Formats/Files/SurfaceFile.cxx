// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SurfaceFile.h"

#include "Ground/Base/FileSystem.h"
#include "Surface/Contour/TriangleNormals.h"

#include <cstdint>
#include <utility>

namespace isosurface
{

bool SurfaceFile::CanRead(const std::string& path)
{
  const auto file = GetLocalFileSystem().OpenForReading(path);
  std::uint8_t head[8] = {};
  return file.IsOk() && (*file)->Read(0, sizeof(head), head).IsOk() &&
    EdgeIndexHeader::HasMagic(head);
}

Result<std::shared_ptr<SurfaceFile>> SurfaceFile::Open(const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, EdgeIndexFile::Open(GetLocalFileSystem(), path));
  return std::shared_ptr<SurfaceFile>(new SurfaceFile(std::move(file)));
}

std::vector<std::string> SurfaceFile::GetAttributes() const
{
  std::vector<std::string> names;
  for (const EdgeIndexAttribute& attribute : this->GetHeader().Attributes)
  {
    if (!attribute.IsNormals)
    {
      names.push_back(attribute.Name);
    }
  }
  return names;
}

Result<Surface> SurfaceFile::Read(const std::vector<std::size_t>& isovalues, bool preview,
  bool normals, int threads, const Progress& progress) const
{
  EdgeIndexSelection selection;
  selection.Isovalues = isovalues;
  selection.Preview = preview;
  ContourRequest request;
  for (const EdgeIndexAttribute& attribute : this->GetHeader().Attributes)
  {
    request.Normals = request.Normals || (normals && !preview && attribute.IsNormals);
  }
  auto surface = this->File->Read(selection, request, threads, progress);
  if (surface.IsOk() && normals && !request.Normals)
  {
    ComputeNormalsOfTriangles(*surface);
  }
  return surface;
}

} // namespace isosurface
