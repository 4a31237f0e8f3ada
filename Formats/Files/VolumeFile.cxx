// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/VolumeFile.h"

#include "Formats/Files/SourceVolume.h"
#include "Formats/Files/StoredVolume.h"
#include "Formats/Files/SurfaceFile.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Opener/VolumeFormat.h"
#include "Formats/Source/FolderFiles.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/VolumeName.h"

#include <filesystem>
#include <system_error>

namespace isosurface
{
namespace
{

/// Gives a volume of one kind as any volume.
template <typename Volume>
Result<std::shared_ptr<VolumeFile>> AsFile(Result<std::shared_ptr<Volume>> opened)
{
  ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
  return std::shared_ptr<VolumeFile>(std::move(*opened));
}

} // namespace

Result<FileKind> FindFileKind(const std::string& name)
{
  const VolumeName parsed = VolumeName::Parse(GetLocalFileSystem(), name);
  std::error_code error;
  if (IsAddress(parsed.Path))
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckReadable(GetLocalFileSystem(), parsed.Path));
  }
  else if (!std::filesystem::exists(parsed.Path, error) &&
    FindFittingNames(GetLocalFileSystem(), parsed.Path, nullptr).empty())
  {
    return Status(StatusCode::NotFound, name + ": there is no such file or folder");
  }
  if (std::filesystem::path(name).extension() == ".bvol")
  {
    return FileKind::BlockedVolume;
  }
  return SurfaceFile::CanRead(name) ? FileKind::Surface : FileKind::Source;
}

Result<std::shared_ptr<VolumeFile>> VolumeFile::Open(
  const std::string& name, const OpeningChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto kind, FindFileKind(name));
  if (kind == FileKind::Surface)
  {
    return Status(StatusCode::InvalidArgument, name + ": is a surface, not a volume");
  }
  if (kind == FileKind::BlockedVolume)
  {
    return AsFile(StoredVolume::Open(name, choice));
  }
  FileSystem& files = GetLocalFileSystem();
  ISOSURFACE_ASSIGN_OR_RETURN(const auto index,
    SourceIndex::FindPartOf(
      files, name, "", choice.Axes, choice.IndexFolder, choice.Place, choice.Bounds));
  const auto state = FindIndexState(files, index);
  return state.IsOk() && *state == IndexState::Current
    ? AsFile(StoredVolume::Open(index.Path, choice))
    : AsFile(SourceVolume::Open(choice.Bounds ? index.Source : name, choice));
}

} // namespace isosurface
