// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/GenerationFolder.h"

#include "Storage/Writing/WriteJournal.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace isosurface
{
namespace
{

std::optional<std::uint64_t> FindNumber(const std::string& name)
{
  if (name.size() < 6 || name.size() > 18 ||
    name.find_first_not_of("0123456789") != std::string::npos)
  {
    return std::nullopt;
  }
  return std::stoull(name);
}

std::string GetPartialPath(const std::string& path)
{
  return path + ".partial";
}

std::string GetParent(const std::string& path)
{
  const std::string parent = std::filesystem::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

} // namespace

void GenerationFolder::RemoveUnnamed(
  FileSystem& files, const std::string& path, const BlockedVolumeHeader& pending, bool isJournaled)
{
  std::vector<TimeStepDescription> named = pending.TimeSteps;
  if (files.Exists(path))
  {
    const auto header = BlockedVolumeHeader::Read(files, path);
    if (!header.IsOk())
    {
      return;
    }
    named.insert(named.end(), header->TimeSteps.begin(), header->TimeSteps.end());
  }
  if (!isJournaled)
  {
    static_cast<void>(files.RemoveAll(WriteJournal::GetPath(files, path)));
  }
  const auto names = files.List(GetStoresFolder(files, path));
  for (std::size_t index = 0; names.IsOk() && index < names->size(); ++index)
  {
    const std::string& name = (*names)[index];
    const bool isNamed = std::any_of(named.begin(), named.end(),
      [&](const TimeStepDescription& step) { return step.Folder == name; });
    if (FindNumber(name) && !isNamed)
    {
      static_cast<void>(files.RemoveAll(GetStoresFolder(files, path) + "/" + name));
    }
  }
}

void GenerationFolder::RemoveUnfinished(FileSystem& files, const std::string& path)
{
  const std::string folder = GetStoresFolder(files, path);
  if (!files.Exists(folder))
  {
    return;
  }
  const auto lock = files.LockFolder(folder);
  if (!lock.IsOk() || !(*lock)->IsExclusive())
  {
    return;
  }
  BlockedVolumeHeader kept;
  const auto text = WriteJournal::ReadText(files, path);
  const auto journal = text.IsOk() ? WriteJournal::Parse(*text, path) : text.GetStatus();
  if (journal.IsOk())
  {
    kept = journal->Finished.value_or(kept);
    kept.TimeSteps.emplace_back().Folder = journal->Folder;
  }
  RemoveUnnamed(files, path, kept, journal.IsOk());
  static_cast<void>(files.RemoveAll(WriteJournal::GetPath(files, path) + ".partial"));
  static_cast<void>(files.RemoveAll(GetPartialPath(path)));
  Discard(files, path, "");
}

Result<std::string> GenerationFolder::Create(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto names, files.List(GetStoresFolder(files, path)));
  std::uint64_t last = 0;
  for (const std::string& name : names)
  {
    last = std::max(last, FindNumber(name).value_or(0));
  }
  char name[32];
  const std::uint64_t next = last + 1;
  std::snprintf(name, sizeof(name), "%06llu", static_cast<unsigned long long>(next));
  const std::string folder = GetStoresFolder(files, path) + "/" + name;
  ISOSURFACE_RETURN_IF_ERROR(files.MakeNewDirectory(folder));
  return std::string(name);
}

Status GenerationFolder::Commit(
  FileSystem& files, const std::string& path, const BlockedVolumeHeader& header, bool& isVisible)
{
  isVisible = false;
  ISOSURFACE_RETURN_IF_ERROR(header.Validate());
  const std::string text = header.Format();
  if (text.size() > BlockedVolumeHeader::MaximumSize)
  {
    return Status(StatusCode::InvalidArgument,
      path + ": its header would have " + std::to_string(text.size()) + " bytes, more than the " +
        std::to_string(BlockedVolumeHeader::MaximumSize) + " of a header; write fewer stores");
  }
  const std::string partial = GetPartialPath(path);
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(partial));
  ISOSURFACE_RETURN_IF_ERROR(file->Append(text.data(), text.size()));
  ISOSURFACE_RETURN_IF_ERROR(file->SyncAndClose());
  ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(GetStoresFolder(files, path)));
  ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(GetParent(path)));
  ISOSURFACE_RETURN_IF_ERROR(files.Rename(partial, path));
  isVisible = true;
  return files.SyncDirectory(GetParent(path));
}

void GenerationFolder::RemoveOlder(FileSystem& files, const std::string& path,
  const std::string& current, const BlockedVolumeHeader& header)
{
  const auto names = files.List(GetStoresFolder(files, path));
  if (!names.IsOk())
  {
    return;
  }
  for (const std::string& name : *names)
  {
    const auto number = FindNumber(name);
    // Higher numbers belong to another writer at work.
    if (number && *number < FindNumber(current).value_or(0) && !header.HasFolder(name))
    {
      static_cast<void>(files.RemoveAll(GetStoresFolder(files, path) + "/" + name));
    }
  }
}

void GenerationFolder::DiscardUnnamed(
  FileSystem& files, const std::string& path, const BlockedVolumeHeader& header)
{
  BlockedVolumeHeader onDisk;
  if (files.Exists(path))
  {
    const auto read = BlockedVolumeHeader::Read(files, path);
    if (!read.IsOk())
    {
      return;
    }
    onDisk = *read;
  }
  for (const TimeStepDescription& step : header.TimeSteps)
  {
    if (!onDisk.HasFolder(step.Folder))
    {
      Discard(files, path, step.Folder);
    }
  }
}

void GenerationFolder::Discard(
  FileSystem& files, const std::string& path, const std::string& current)
{
  if (!current.empty())
  {
    static_cast<void>(files.RemoveAll(GetPartialPath(path)));
    static_cast<void>(files.RemoveAll(GetStoresFolder(files, path) + "/" + current));
  }
  const auto names = files.List(GetStoresFolder(files, path));
  if (names.IsOk() && names->empty())
  {
    static_cast<void>(files.RemoveAll(GetStoresFolder(files, path)));
  }
}

} // namespace isosurface
