// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SurfaceFile.h"

#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Surface/Contour/TriangleNormals.h"

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

std::vector<InterpolatedArray> SurfaceFile::GetArrays() const
{
  std::vector<InterpolatedArray> arrays;
  for (const EdgeIndexAttribute& attribute : this->GetHeader().Attributes)
  {
    if (!attribute.IsNormals)
    {
      arrays.push_back({ attribute.Name, {}, { attribute.Type, attribute.NumberOfComponents } });
    }
  }
  return arrays;
}

VertexBox SurfaceFile::FindVertices(const std::array<double, 6>& bounds) const
{
  return VertexPlaces(this->GetHeader().Geometry)
    .FindVerticesAround({ bounds[0], bounds[2], bounds[4] }, { bounds[1], bounds[3], bounds[5] });
}

Result<Surface> SurfaceFile::Read(const EdgeIndexSelection& selection, ContourRequest request,
  bool normals, int threads, const Progress& progress) const
{
  for (const EdgeIndexAttribute& attribute : this->GetHeader().Attributes)
  {
    request.Normals = request.Normals || (normals && !selection.Preview && attribute.IsNormals);
  }
  auto surface = this->File->Read(selection, request, threads, progress);
  if (surface.IsOk() && normals && !request.Normals)
  {
    ComputeNormalsOfTriangles(*surface);
  }
  return surface;
}

} // namespace isosurface
