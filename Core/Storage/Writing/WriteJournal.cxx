// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/WriteJournal.h"

#include "Ground/Base/Checksum.h"
#include "Storage/Store/JsonDocument.h"

#include <nlohmann/json.hpp>

#include <limits>

namespace isosurface
{
namespace
{

constexpr const char* JournalFormat = "ScalableIsosurface unfinished write";
constexpr std::int64_t JournalVersion = 1;

} // namespace

std::string WriteJournal::GetPath(FileSystem& files, const std::string& volumePath)
{
  return GetStoresFolder(files, volumePath) + "/journal";
}

std::uint64_t WriteJournal::ComputePlan(const BlockedVolumeHeader& planned)
{
  const std::string text = planned.Format();
  return ComputeChecksum(text.data(), text.size());
}

Status WriteJournal::Write(FileSystem& files, const std::string& volumePath) const
{
  const std::string text =
    FormatDocument({ { "format", JournalFormat }, { "formatVersion", JournalVersion },
      { "finished", this->Finished ? this->Finished->Format() : "" },
      { "stores", this->NumberOfStores }, { "folder", this->Folder },
      { "plan", FormatChecksum(this->Plan) }, { "blocks", this->Blocks },
      { "checkpoint", this->Checkpoint } });
  const std::string path = GetPath(files, volumePath);
  const std::string partial = path + ".partial";
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(partial));
  ISOSURFACE_RETURN_IF_ERROR(file->Append(text.data(), text.size()));
  ISOSURFACE_RETURN_IF_ERROR(file->SyncAndClose());
  ISOSURFACE_RETURN_IF_ERROR(files.Rename(partial, path));
  return files.SyncDirectory(GetStoresFolder(files, volumePath));
}

Result<std::string> WriteJournal::ReadText(FileSystem& files, const std::string& volumePath)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(GetPath(files, volumePath)));
  std::string text(static_cast<std::size_t>(file->GetSize()), '\0');
  ISOSURFACE_RETURN_IF_ERROR(file->Read(0, text.size(), text.data()));
  return text;
}

Result<WriteJournal> WriteJournal::Parse(const std::string& text, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto document, ParseDocument(text, path, JournalFormat, JournalVersion));
  constexpr std::int64_t any = std::numeric_limits<std::int64_t>::max();
  Status status;
  JsonMembers members(document, path, "", status);
  WriteJournal journal;
  journal.NumberOfStores = static_cast<std::uint32_t>(
    members.GetInteger("stores", 1, std::numeric_limits<std::uint32_t>::max()));
  journal.Folder = members.GetString("folder");
  journal.Plan = members.GetChecksum("plan");
  journal.Blocks = members.GetInteger("blocks", 0, any);
  journal.Checkpoint = members.GetInteger("checkpoint", 0, any);
  if (journal.Folder.find_first_not_of("0123456789") != std::string::npos)
  {
    members.Fail("folder", "is no number");
  }
  const std::string finished = members.GetString("finished");
  ISOSURFACE_RETURN_IF_ERROR(status);
  if (!finished.empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(journal.Finished, BlockedVolumeHeader::Parse(finished, path));
  }
  return journal;
}

std::optional<BlockedVolumeHeader> WriteJournal::FindFinished(
  const BlockedVolumeHeader& planned) const
{
  if (!this->Finished || this->Finished->TimeSteps.size() < planned.TimeSteps.size())
  {
    return std::nullopt;
  }
  BlockedVolumeHeader finished = *this->Finished;
  finished.TimeSteps.resize(planned.TimeSteps.size());
  BlockedVolumeHeader asPlanned = finished;
  TimeStepDescription& step = asPlanned.TimeSteps.back();
  step = TimeStepDescription{};
  step.Time = finished.TimeSteps.back().Time;
  step.Source = finished.TimeSteps.back().Source;
  step.CopyOf = finished.TimeSteps.back().CopyOf;
  step.Overviews.resize(planned.Overviews.size());
  return asPlanned.Format() == planned.Format() ? std::optional(finished) : std::nullopt;
}

} // namespace isosurface
