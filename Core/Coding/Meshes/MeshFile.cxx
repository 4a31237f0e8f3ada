// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/MeshFile.h"

#include "Coding/Meshes/GlbFile.h"
#include "Coding/Meshes/ObjFile.h"
#include "Coding/Meshes/PlyFile.h"
#include "Coding/Meshes/StlFile.h"

#include <limits>
#include <sstream>

namespace isosurface
{
namespace
{

bool EndsIn(const std::string& path, const std::string& ending)
{
  return path.size() > ending.size() &&
    path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

} // namespace

std::string ToText(const Vector3& place)
{
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::digits10);
  text << place[0] << " " << place[1] << " " << place[2];
  return text.str();
}

bool MeshFile::Knows(const std::string& path)
{
  return EndsIn(path, ".stl") || EndsIn(path, ".ply") || EndsIn(path, ".glb") ||
    EndsIn(path, ".obj");
}

std::uint64_t MeshFile::EstimateBytes(const Settings& settings)
{
  constexpr std::uint64_t cornersBytes = 3 * sizeof(std::uint32_t);
  if (EndsIn(settings.Path, ".stl"))
  {
    return StlFile::TriangleSize * settings.Triangles;
  }
  if (EndsIn(settings.Path, ".obj"))
  {
    return ObjFile::EstimateBytes(settings);
  }
  const bool isDouble = settings.HasDoublePoints && EndsIn(settings.Path, ".ply");
  const std::uint64_t pointBytes =
    3 * ((settings.HasNormals ? sizeof(float) : 0) + (isDouble ? sizeof(double) : sizeof(float)));
  return pointBytes * settings.Points + cornersBytes * settings.Triangles +
    (EndsIn(settings.Path, ".ply") ? settings.Triangles : 0);
}

Status MeshFile::CheckLimits(const Settings& settings)
{
  constexpr double limit = 4294967296.0;
  // Points on the faces of blocks are counted twice, and not all have two triangles.
  constexpr double certain = 0.8;
  const auto isBeyond = [](std::uint64_t estimate)
  { return certain * static_cast<double>(estimate) > limit; };
  const auto refuse = [&settings](std::uint64_t estimate, const char* most)
  {
    return Status(StatusCode::Unsupported,
      settings.Path + ": would have about " + std::to_string(estimate) + " " + most +
        ". Take another format, or fewer triangles (--triangles)");
  };
  if (EndsIn(settings.Path, ".stl") && isBeyond(settings.Triangles))
  {
    return refuse(settings.Triangles, "triangles; an .stl file has at most 4,294,967,295");
  }
  if (EndsIn(settings.Path, ".ply") && isBeyond(settings.Points))
  {
    return refuse(settings.Points, "points; a .ply file has at most 4,294,967,295");
  }
  const std::uint64_t bytes = EstimateBytes(settings);
  return EndsIn(settings.Path, ".glb") && !settings.Compression && isBeyond(bytes)
    ? refuse(bytes >> 20, "MiB; a .glb file has at most 4096 MiB, and --compress makes it smaller")
    : Status::Ok();
}

Result<std::unique_ptr<MeshFile>> MeshFile::Create(
  FileSystem& files, const EdgeIndexHeader& header, const Settings& settings)
{
  ISOSURFACE_RETURN_IF_ERROR(CheckLimits(settings));
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(settings.Partial));
  if (EndsIn(settings.Path, ".stl"))
  {
    return StlFile::Create(std::move(file), settings);
  }
  if (EndsIn(settings.Path, ".ply"))
  {
    return PlyFile::Create(files, std::move(file), settings);
  }
  if (EndsIn(settings.Path, ".obj"))
  {
    return ObjFile::Create(std::move(file), header, settings);
  }
  return GlbFile::Create(std::move(file), header, settings);
}

} // namespace isosurface
