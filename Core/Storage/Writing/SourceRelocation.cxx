// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/SourceRelocation.h"

#include "Ground/Volume/VolumeName.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Storage/Writing/GenerationFolder.h"

#include <filesystem>
#include <set>

namespace isosurface
{
namespace
{

std::string GetLastName(const std::string& path)
{
  const std::filesystem::path normal = std::filesystem::path(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).filename().string();
}

/// The record of a source in a new place; `isSame` tells whether its files are as they were.
Result<SourceRecord> MoveRecord(FileSystem& files, VolumeOpener opener, const std::string& path,
  const VolumeName& name, const BlockedVolumeHeader& header, const SourceRecord& old, bool& isSame)
{
  const VolumeName place = { name.Path, name.Within.empty() ? old.Within : name.Within };
  ISOSURFACE_ASSIGN_OR_RETURN(auto record,
    DescribeSource(files, opener, path, place.GetText(), old, header.Grid, header.Arrays));
  if (record.Metadata != old.Metadata)
  {
    return Status(StatusCode::Corrupt,
      place.GetText() + ": is not what " + path + " was made of: its samples are stored otherwise");
  }
  isSame = isSame && record.State == old.State;
  return record;
}

Status CheckSamples(FileSystem& files, VolumeOpener opener, const std::string& path,
  const BlockedVolumeHeader& header, int threads, const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto found, VerifyBlockedVolume(path, files, threads, progress, opener, &header));
  return found.Faults.empty() ? Status::Ok() : found.Faults.front();
}

} // namespace

Status RelocateSource(FileSystem& files, VolumeOpener opener, const std::string& path,
  const std::string& source, int threads, const Progress& progress)
{
  ISOSURFACE_RETURN_IF_ERROR(files.CheckRegular(path, "write"));
  if (!files.Exists(path))
  {
    return Status(StatusCode::NotFound, path + ": there is no such file");
  }
  const auto lock = files.LockFolder(GetStoresFolder(files, path));
  ISOSURFACE_RETURN_IF_ERROR(lock.GetStatus());
  ISOSURFACE_ASSIGN_OR_RETURN(auto header, BlockedVolumeHeader::Read(files, path));
  if (!header.IsInPlace())
  {
    return Status(
      StatusCode::InvalidArgument, path + ": has its samples itself: it is not in place");
  }
  const VolumeName name = VolumeName::Parse(files, source);
  if (!files.Exists(name.Path))
  {
    return Status(StatusCode::NotFound, name.Path + ": there is no such file or folder");
  }
  std::set<std::string> places;
  for (const TimeStepDescription& step : header.TimeSteps)
  {
    places.insert(step.Source->Path);
  }
  bool isSame = true;
  bool isFound = false;
  for (TimeStepDescription& step : header.TimeSteps)
  {
    if (places.size() == 1 || GetLastName(step.Source->Path) == GetLastName(name.Path))
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        step.Source, MoveRecord(files, opener, path, name, header, *step.Source, isSame));
      isFound = true;
    }
  }
  if (!isFound)
  {
    return Status(StatusCode::InvalidArgument,
      path + ": has several sources, none of the name " + GetLastName(name.Path));
  }
  if (!isSame)
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckSamples(files, opener, path, header, threads, progress));
  }
  bool isVisible = false;
  return GenerationFolder::Commit(files, path, header, isVisible);
}

} // namespace isosurface
