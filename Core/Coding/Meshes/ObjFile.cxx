// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/ObjFile.h"

#include <cstdio>
#include <limits>
#include <sstream>

namespace isosurface
{
namespace
{

constexpr std::size_t TextAtOnce = std::size_t{ 4 } << 20;

/// A line of three numbers, from which the same floats or doubles are read.
template <typename Real>
void AppendLine(const char* key, const Real* numbers, std::string& text)
{
  char line[96];
  std::snprintf(line, sizeof(line), "%s %.*g %.*g %.*g\n", key,
    std::numeric_limits<Real>::max_digits10, static_cast<double>(numbers[0]),
    std::numeric_limits<Real>::max_digits10, static_cast<double>(numbers[1]),
    std::numeric_limits<Real>::max_digits10, static_cast<double>(numbers[2]));
  text += line;
}

} // namespace

std::uint64_t ObjFile::EstimateBytes(const Settings& settings)
{
  constexpr std::uint64_t lineOfPoint = 34;
  constexpr std::uint64_t lineOfTriangle = 28;
  const std::uint64_t lines = settings.HasNormals ? 2 : 1;
  return lines * (lineOfPoint * settings.Points + lineOfTriangle * settings.Triangles);
}

Result<std::unique_ptr<MeshFile>> ObjFile::Create(
  std::unique_ptr<WritableFile> file, const EdgeIndexHeader& header, const Settings& settings)
{
  const std::string text = "# Isosurface of an edge-index file\n";
  ISOSURFACE_RETURN_IF_ERROR(file->Append(text.data(), text.size()));
  return std::unique_ptr<MeshFile>(new ObjFile(std::move(file), header, settings.HasNormals));
}

Status ObjFile::WriteIfMany(std::string& text)
{
  Status status;
  if (text.size() >= TextAtOnce)
  {
    status = this->File->Append(text.data(), text.size());
    text.clear();
  }
  return status;
}

Status ObjFile::Append(const Mesh& mesh, const PointNumbers& numbers)
{
  std::string text;
  for (std::size_t point = 0; point < mesh.NumberOfPoints; ++point)
  {
    if (numbers.Values[point] < numbers.First)
    {
      continue;
    }
    if (mesh.DoublePoints)
    {
      AppendLine("v", mesh.DoublePoints + 3 * point, text);
    }
    else
    {
      AppendLine("v", mesh.Points + 3 * point, text);
    }
    if (this->HasNormals)
    {
      AppendLine("vn", mesh.Normals + 3 * point, text);
    }
    ISOSURFACE_RETURN_IF_ERROR(this->WriteIfMany(text));
  }
  std::ostringstream group;
  group << "g isovalue_" << this->Header.Isovalues[mesh.Isovalue] << "\n";
  text += group.str();
  for (std::size_t triangle = 0; triangle < mesh.NumberOfTriangles; ++triangle)
  {
    text += "f";
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      const std::string number =
        std::to_string(numbers.Values[mesh.Corners[3 * triangle + corner]] + 1);
      text += " " + (this->HasNormals ? number + "//" + number : number);
    }
    text += "\n";
    ISOSURFACE_RETURN_IF_ERROR(this->WriteIfMany(text));
  }
  return this->File->Append(text.data(), text.size());
}

} // namespace isosurface
