// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/SurfaceMeshes.h"

#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isosurface
{
namespace
{

template <typename T>
bool AreFinite(const Buffer<T>& values)
{
  return std::all_of(values.begin(), values.end(), [](T value) { return std::isfinite(value); });
}

} // namespace

Status VisitMeshes(const Surface& surface, const std::optional<Vector3>& origin, bool hasNormals,
  const std::function<Status(Mesh& mesh)>& visit)
{
  std::vector<float> local(surface.DoublePoints.GetSize());
  for (std::size_t value = 0; value < local.size(); ++value)
  {
    local[value] = static_cast<float>(surface.DoublePoints[value] - (*origin)[value % 3]);
  }
  std::vector<std::uint32_t> corners;
  for (std::size_t number = 0; number < surface.Parts.size(); ++number)
  {
    const SurfacePart& part = surface.Parts[number];
    if (part.NumberOfCells == 0)
    {
      continue;
    }
    corners.resize(3 * part.NumberOfCells);
    for (std::size_t corner = 0; corner < corners.size(); ++corner)
    {
      corners[corner] =
        static_cast<std::uint32_t>(surface.Connectivity[3 * part.FirstCell + corner] -
          static_cast<std::int64_t>(part.FirstPoint));
    }
    Mesh mesh;
    mesh.Points = (origin ? local.data() : surface.Points.GetData()) + 3 * part.FirstPoint;
    mesh.DoublePoints = origin ? surface.DoublePoints.GetData() + 3 * part.FirstPoint : nullptr;
    mesh.Normals = hasNormals ? surface.Normals.GetData() + 3 * part.FirstPoint : nullptr;
    mesh.GlobalIds =
      surface.GlobalIds.IsEmpty() ? nullptr : surface.GlobalIds.GetData() + part.FirstPoint;
    mesh.NumberOfPoints = part.NumberOfPoints;
    mesh.Corners = corners.data();
    mesh.NumberOfTriangles = part.NumberOfCells;
    mesh.Isovalue = number;
    ISOSURFACE_RETURN_IF_ERROR(visit(mesh));
  }
  return Status::Ok();
}

Status SaveSurface(FileSystem& files, const Surface& surface, bool hasNormals,
  const EdgeIndexHeader& header, double unitInMetres, const std::string& path)
{
  if (!MeshFile::Knows(path))
  {
    return { StatusCode::InvalidArgument,
      path + ": a surface is saved as .stl, .ply, .glb or .obj" };
  }
  if (!AreFinite(surface.Points) || !AreFinite(surface.DoublePoints))
  {
    return { StatusCode::InvalidArgument,
      path +
        ": the surface has points that are not finite, as beside samples that are not numbers" };
  }
  MeshFile::Settings settings;
  settings.Path = path;
  settings.Partial = GetPartialEdgeIndexPath(path);
  settings.MostMeshes = surface.Parts.size();
  settings.HasNormals = hasNormals;
  settings.UnitInMetres = unitInMetres;
  settings.HasDoublePoints = surface.HasDoublePoints;
  settings.Points = surface.NumberOfPoints;
  settings.Triangles = surface.NumberOfTriangles;
  std::optional<Vector3> origin;
  if (surface.HasDoublePoints)
  {
    origin = surface.NumberOfPoints > 0 ? surface.GetPoint(0) : Vector3{};
    settings.Origin = *origin;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto lock, LockEdgeIndexFile(files, path));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, MeshFile::Create(files, header, settings));
  PointNumbers numbers;
  ISOSURFACE_RETURN_IF_ERROR(VisitMeshes(surface, origin, hasNormals,
    [&](Mesh& mesh)
    {
      numbers.First += numbers.Values.size();
      numbers.Values.resize(mesh.NumberOfPoints);
      std::iota(numbers.Values.begin(), numbers.Values.end(), numbers.First);
      return file->Append(mesh, numbers);
    }));
  ISOSURFACE_RETURN_IF_ERROR(file->Finish());
  return PutEdgeIndexFileInPlace(files, path, lock);
}

} // namespace isosurface
