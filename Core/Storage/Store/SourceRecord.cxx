// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/SourceRecord.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/VolumeName.h"
#include "Storage/Store/JsonDocument.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

std::filesystem::path FindFolder(const std::string& header)
{
  const std::filesystem::path folder = std::filesystem::path(header).parent_path();
  return folder.empty() ? std::filesystem::path(".") : folder;
}

std::string MakeAbsolutePath(const std::string& path)
{
  if (IsAddress(path))
  {
    return path;
  }
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::weakly_canonical(path, error);
  return error ? path : absolute.string();
}

/// Whether there is a file, a folder, or one for a pattern: then the name of a volume may begin so.
bool IsThere(FileSystem& files, const std::string& path)
{
  return VolumeName::Parse(files, path + ":array").Within == "array";
}

/// Everything that decides which bytes are which samples.
std::uint64_t ComputeMetadata(const OpenedVolume& volume)
{
  std::string text = volume.Storage;
  for (const std::int64_t size : volume.Grid.GetDimensions())
  {
    text += "\n" + std::to_string(size);
  }
  for (const std::int64_t size : volume.Source->GetChunk().value_or(Index3{}))
  {
    text += "\n" + std::to_string(size);
  }
  for (const ArrayDescription& array : volume.Arrays)
  {
    text +=
      "\n" + std::string(GetValueTypeName(array.Type)) + "\n" + std::to_string(array.Components);
  }
  return ComputeChecksum(text.data(), text.size());
}

/// How the arrays of a source differ from those that are wanted, or "".
std::string FindDifference(
  const OpenedVolume& volume, const GridGeometry& grid, const std::vector<ArrayDescription>& arrays)
{
  if (volume.Grid.GetDimensions() != grid.GetDimensions())
  {
    return "it has another number of samples";
  }
  const bool areSame =
    std::equal(volume.Arrays.begin(), volume.Arrays.end(), arrays.begin(), arrays.end(),
      [](const ArrayDescription& a, const ArrayDescription& b)
      { return a.Type == b.Type && a.Components == b.Components; });
  return areSame ? "" : "it has other arrays";
}

Status MakeChanged(
  const std::string& name, const std::string& header, const std::string& difference)
{
  return Status(StatusCode::Corrupt,
    name + ": was changed since " + header + " was made of it: " + difference +
      "; index it again, or name its new place: blockvolume --source PATH " + header);
}

} // namespace

VolumeChoice SourceRecord::MakeChoice(const std::vector<std::string>& arrays) const
{
  VolumeChoice choice;
  choice.Step = this->Step;
  choice.Axes = this->Axes;
  choice.IgnoresPlaces = true;
  choice.IsRecorded = true; // release 1.0.0 wrote axes of formats that ignore them
  choice.Arrays = arrays;
  choice.CacheBytes = 0; // whole chunks are read, and kept elsewhere
  return choice;
}

std::uint64_t SourceRecord::ComputeDataset() const
{
  Fingerprint fingerprint;
  fingerprint.AddText(this->AbsolutePath);
  fingerprint.AddText(this->Within);
  fingerprint.AddText(this->Axes);
  fingerprint.AddNumber(this->Step);
  for (const std::string& array : this->Arrays)
  {
    fingerprint.AddText(array);
  }
  fingerprint.AddNumber(this->State.Files);
  fingerprint.AddNumber(this->State.Bytes);
  fingerprint.AddNumber(static_cast<std::uint64_t>(this->State.Modified));
  fingerprint.AddNumber(this->Metadata);
  return fingerprint.Get();
}

std::string SourceRecord::FindPath(FileSystem& files, const std::string& header) const
{
  if (IsAddress(header))
  {
    return FindBeside(header, this->Path);
  }
  if (IsAddress(this->AbsolutePath))
  {
    return this->AbsolutePath;
  }
  const std::string path = (FindFolder(header) / this->Path).lexically_normal().string();
  return IsThere(files, path) || !IsThere(files, this->AbsolutePath) ? path : this->AbsolutePath;
}

Status SourceRecord::Validate() const
{
  const bool isText =
    IsUtf8(this->Path) && IsUtf8(this->AbsolutePath) && IsUtf8(this->Within) && IsUtf8(this->Axes);
  const Index3 chunk = this->Chunk.value_or(Index3{ 1, 1, 1 });
  const bool isChunk = std::all_of(chunk.begin(), chunk.end(),
    [](std::int64_t size) { return size >= 1 && size <= MaximumChunk; });
  const bool areNames =
    !this->Arrays.empty() && std::all_of(this->Arrays.begin(), this->Arrays.end(), IsUtf8);
  return isText && isChunk && areNames && !this->Path.empty()
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument,
        "a source of timeSteps[] has no path or arrays, an impossible chunk, or is not UTF-8");
}

Result<OpenedVolume> OpenSource(FileSystem& files, VolumeOpener opener, const std::string& header,
  const std::string& name, const VolumeChoice& choice)
{
  if (!opener)
  {
    return Status(StatusCode::Unsupported,
      name + ": has the samples of " + header + ", but this program reads no files of its format");
  }
  return opener(files, name, choice);
}

Result<SourceRecord> DescribeSource(FileSystem& files, VolumeOpener opener,
  const std::string& header, const std::string& text, const SourceRecord& wanted,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays)
{
  const VolumeName name = VolumeName::Parse(files, text);
  SourceRecord record;
  record.Path = MakeRelativePath(header, name.Path);
  record.AbsolutePath = MakeAbsolutePath(name.Path);
  record.Within = name.Within;
  record.Axes = wanted.Axes;
  record.Step = wanted.Step;
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto volume, OpenSource(files, opener, header, text, record.MakeChoice(wanted.Arrays)));
  const std::string difference = FindDifference(volume, grid, arrays);
  if (!difference.empty())
  {
    return Status(StatusCode::InvalidArgument, text + ": cannot be indexed: " + difference);
  }
  record.Chunk = volume.Source->GetChunk();
  for (const ArrayDescription& array : volume.Arrays)
  {
    record.Arrays.push_back(array.Name);
  }
  record.Metadata = ComputeMetadata(volume);
  ISOSURFACE_ASSIGN_OR_RETURN(record.State, FindStateOfAll(files, volume.Files));
  return record;
}

Status CheckSource(FileSystem& files, VolumeOpener opener, const std::string& header,
  const SourceRecord& record, const GridGeometry& grid, const std::vector<ArrayDescription>& arrays)
{
  const std::string path = record.FindPath(files, header);
  if (!IsThere(files, path))
  {
    return Status(StatusCode::NotFound,
      path + ": has the samples of " + header +
        ", but is missing; name its new place: "
        "blockvolume --source PATH " +
        header);
  }
  const auto inside = files.List(path);
  if (!inside.IsOk() || inside->empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(files.CheckRegular(path, "read"));
  }
  const VolumeName name = { path, record.Within };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto volume,
    OpenSource(files, opener, header, name.GetText(), record.MakeChoice(record.Arrays)));
  std::string difference = FindDifference(volume, grid, arrays);
  for (std::size_t array = 0; difference.empty() && array < volume.Arrays.size(); ++array)
  {
    difference = volume.Arrays[array].Name == record.Arrays[array]
      ? ""
      : "it has no array \"" + record.Arrays[array] + "\"";
  }
  if (difference.empty() && ComputeMetadata(volume) != record.Metadata)
  {
    difference = "its samples are stored otherwise";
  }
  return difference.empty() ? CheckSourceFiles(files, header, name.GetText(), record, volume.Files)
                            : MakeChanged(name.GetText(), header, difference);
}

Status CheckSourceFiles(FileSystem& files, const std::string& header, const std::string& name,
  const SourceRecord& record, const std::vector<std::string>& paths)
{
  if (record.State.Files > SourceRecord::MaximumFilesToCheck)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto state, FindStateOfAll(files, paths));
  const std::string difference = state.Files != record.State.Files
    ? "it has another number of files"
    : state.Bytes != record.State.Bytes       ? "it has another size"
    : state.Modified != record.State.Modified ? "it was modified at another time"
                                              : "";
  return difference.empty() ? Status::Ok() : MakeChanged(name, header, difference);
}

Result<FileState> FindStateOfAll(FileSystem& files, const std::vector<std::string>& paths)
{
  FileState all;
  files.LookFor(paths);
  for (const std::string& path : paths)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto state, files.FindState(path));
    all.Modified = all.Files == 0 ? state.Modified : std::max(all.Modified, state.Modified);
    all.Files += state.Files;
    all.Bytes += state.Bytes;
  }
  return all;
}

Result<SourceFiles> SourceFiles::Find(FileSystem& files, std::vector<std::string> paths)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto state, FindStateOfAll(files, paths));
  return SourceFiles{ std::move(paths), state };
}

std::string MakeRelativePath(const std::string& header, const std::string& path)
{
  if (IsAddress(path))
  {
    return path;
  }
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::weakly_canonical(FindFolder(header), error);
  const std::filesystem::path to = std::filesystem::weakly_canonical(path, error);
  const std::filesystem::path relative = to.lexically_relative(folder);
  return error || relative.empty() ? MakeAbsolutePath(path) : relative.string();
}

} // namespace isosurface
