// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/StlFile.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

namespace isosurface
{
namespace
{

constexpr std::size_t TextSize = 80;
constexpr std::size_t TrianglesAtOnce = 65536;

using Vector = std::array<float, 3>;

/// The unit normal of a triangle, or 0 if it has no area.
Vector FindNormal(const float* a, const float* b, const float* c)
{
  double normal[3];
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::size_t second = (axis + 1) % 3;
    const std::size_t third = (axis + 2) % 3;
    normal[axis] = (double{ b[second] } - a[second]) * (double{ c[third] } - a[third]) -
      (double{ b[third] } - a[third]) * (double{ c[second] } - a[second]);
  }
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  Vector unit{};
  for (std::size_t axis = 0; axis < 3 && length > 0; ++axis)
  {
    unit[axis] = static_cast<float>(normal[axis] / length);
  }
  return unit;
}

/// The bytes of a triangle in the file; returns where they end.
std::uint8_t* StoreTriangle(const Mesh& mesh, const std::uint32_t* corners, std::uint8_t* to)
{
  const float* points[3];
  for (std::size_t corner = 0; corner < 3; ++corner)
  {
    points[corner] = mesh.Points + std::size_t{ 3 } * corners[corner];
  }
  const Vector normal = FindNormal(points[0], points[1], points[2]);
  for (const float* vector : { normal.data(), points[0], points[1], points[2] })
  {
    for (std::size_t axis = 0; axis < 3; ++axis, to += sizeof(float))
    {
      StoreLittleEndian(to, vector[axis]);
    }
  }
  StoreLittleEndian(to, std::uint16_t{ 0 });
  return to + sizeof(std::uint16_t);
}

} // namespace

Result<std::unique_ptr<MeshFile>> StlFile::Create(
  std::unique_ptr<WritableFile> file, const Settings& settings)
{
  std::vector<std::uint8_t> head(TextSize + sizeof(std::uint32_t), std::uint8_t{ ' ' });
  // "solid" would say that it is text.
  const std::string text = settings.HasDoublePoints ? "Isosurface, from " + ToText(settings.Origin)
                                                    : "Isosurface of an edge-index file";
  std::memcpy(head.data(), text.data(), std::min(text.size(), TextSize));
  ISOSURFACE_RETURN_IF_ERROR(file->Append(head.data(), head.size()));
  return std::unique_ptr<MeshFile>(new StlFile(std::move(file)));
}

Status StlFile::Append(const Mesh& mesh, const PointNumbers&)
{
  this->NumberOfTriangles += mesh.NumberOfTriangles;
  if (this->NumberOfTriangles > std::numeric_limits<std::uint32_t>::max())
  {
    return Status(StatusCode::Unsupported,
      this->File->GetPath() + ": more triangles than the 4,294,967,295 that an .stl file can have");
  }
  std::vector<std::uint8_t> bytes(TriangleSize * std::min(TrianglesAtOnce, mesh.NumberOfTriangles));
  std::uint8_t* to = bytes.data();
  for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
  {
    to = StoreTriangle(mesh, mesh.Corners + 3 * triangle, to);
    if (to == bytes.data() + bytes.size() || triangle + 1 == mesh.NumberOfTriangles)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->File->Append(bytes.data(), static_cast<std::size_t>(to - bytes.data())));
      to = bytes.data();
    }
  }
  return Status::Ok();
}

Status StlFile::Finish()
{
  std::vector<std::uint8_t> count;
  AppendLittleEndian(count, static_cast<std::uint32_t>(this->NumberOfTriangles));
  ISOSURFACE_RETURN_IF_ERROR(this->File->WriteAt(TextSize, count.data(), count.size()));
  return this->File->SyncAndClose();
}

} // namespace isosurface
