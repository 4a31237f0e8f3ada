// SPDX-License-Identifier: BSD-3-Clause
#include "MeshFile.h"

#include "GlbFile.h"
#include "PlyFile.h"
#include "StlFile.h"

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

bool MeshFile::Knows(const std::string& path)
{
  return EndsIn(path, ".stl") || EndsIn(path, ".ply") || EndsIn(path, ".glb");
}

Result<std::unique_ptr<MeshFile>> MeshFile::Create(
  FileSystem& files, const EdgeIndexHeader& header, const Settings& settings)
{
  auto file = files.CreateForWriting(settings.Path);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  if (EndsIn(settings.Path, ".stl"))
  {
    return StlFile::Create(std::move(*file));
  }
  if (EndsIn(settings.Path, ".ply"))
  {
    return PlyFile::Create(files, std::move(*file), settings);
  }
  return GlbFile::Create(std::move(*file), header, settings);
}

} // namespace isosurface
