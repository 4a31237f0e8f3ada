// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Verification/VolumeRepair.h"

#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Verification/MergedStore.h"

#include <cstddef>

namespace isosurface
{
namespace
{

/// What is written beside the files of a replica, before these are replaced.
std::string GetPartialFolder(const std::string& folder)
{
  return folder + "/restored.partial";
}

/// Repairs the volume or one of its overviews, store by store.
class PartRepair
{
public:
  PartRepair(FileSystem& files, std::string path, const BlockedVolumeHeader& header, int threads,
    VolumeRepair& done)
    : Files(files)
    , Path(std::move(path))
    , Header(header)
    , Threads(threads)
    , Done(done)
  {
  }

  Status Repair(const TimeStepDescription& step, std::uint32_t store)
  {
    const std::uint32_t stores = this->Header.NumberOfStores;
    std::vector<std::string> sound;
    std::vector<std::string> damaged;
    for (std::uint32_t replica = 0; replica < this->Header.NumberOfReplicas; ++replica)
    {
      const std::string folder =
        GetReplicaFolder(this->Files, this->Path, step.Folder, store, replica, stores);
      // Of a repair that was killed.
      ISOSURFACE_RETURN_IF_ERROR(this->Files.RemoveAll(GetPartialFolder(folder)));
      const bool isSound =
        CheckStore(this->Files, this->Header, step, store, folder, this->Threads).empty();
      (isSound ? sound : damaged).push_back(folder);
    }
    if (!damaged.empty() && sound.empty())
    {
      const Status whole =
        CheckReplicas(this->Files, this->Header, step, store, damaged, this->Threads);
      if (!whole.IsOk())
      {
        this->Done.Refused.push_back(whole);
        return Status::Ok();
      }
    }
    for (const std::string& folder : damaged)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->Restore(step, store, sound.empty() ? damaged : sound, folder));
      sound.assign(1, folder);
    }
    return Status::Ok();
  }

private:
  /// Writes a replica anew from others, which have all of it.
  Status Restore(const TimeStepDescription& step, std::uint32_t store,
    const std::vector<std::string>& from, const std::string& folder)
  {
    const std::string partial = GetPartialFolder(folder);
    MergedStore merged(this->Files, this->Header, step, store, from);
    ISOSURFACE_RETURN_IF_ERROR(this->Files.MakeDirectories(partial));
    const std::vector<std::string> names = merged.ListNames();
    for (const std::string& name : names)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        CopyFile(merged, from.front() + name, this->Files, partial + name));
    }
    ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(partial));
    const std::vector<Status> faults =
      CheckStore(this->Files, this->Header, step, store, partial, this->Threads);
    if (!faults.empty())
    {
      // The disk, or somebody else, has changed it meanwhile.
      static_cast<void>(this->Files.RemoveAll(partial));
      return faults.front();
    }
    for (const std::string& name : names)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Files.Rename(partial + name, folder + name));
    }
    ISOSURFACE_RETURN_IF_ERROR(this->Files.RemoveAll(partial));
    ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(folder));
    ISOSURFACE_RETURN_IF_ERROR(this->Files.SyncDirectory(folder.substr(0, folder.rfind('/'))));
    this->Done.Restored.push_back(folder);
    const auto state = this->Files.FindState(folder + names.front());
    this->Done.Bytes += state.IsOk() ? state->Bytes : 0;
    return Status::Ok();
  }

  FileSystem& Files;
  std::string Path;
  const BlockedVolumeHeader& Header;
  int Threads;
  VolumeRepair& Done;
};

} // namespace

Result<VolumeRepair> RepairBlockedVolume(
  const std::string& path, FileSystem& files, int threads, const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto header, BlockedVolumeHeader::Read(files, path));
  if (header.NumberOfReplicas == 1)
  {
    return Status(StatusCode::InvalidArgument,
      path + ": cannot be repaired: it was written without replicas (--replicas)");
  }
  const auto lock = files.LockFolder(GetStoresFolder(files, path));
  ISOSURFACE_RETURN_IF_ERROR(lock.GetStatus());
  std::vector<BlockedVolumeHeader> parts = { header };
  double stores = header.NumberOfStores;
  for (std::size_t overview = 0; overview < header.Overviews.size(); ++overview)
  {
    parts.push_back(header.MakeOverview(overview));
    stores += parts.back().NumberOfStores;
  }
  stores *= static_cast<double>(header.TimeSteps.size());
  VolumeRepair done;
  double count = 0;
  for (std::size_t step = 0; step < header.TimeSteps.size(); ++step)
  {
    for (const BlockedVolumeHeader& part : parts)
    {
      PartRepair repair(files, path, part, threads, done);
      for (std::uint32_t store = 0; store < part.NumberOfStores; ++store, ++count)
      {
        if (progress && !progress(count / stores))
        {
          return Status(StatusCode::Aborted, path + ": the repair was aborted");
        }
        ISOSURFACE_RETURN_IF_ERROR(repair.Repair(part.TimeSteps[step], store));
      }
    }
  }
  return done;
}

} // namespace isosurface
