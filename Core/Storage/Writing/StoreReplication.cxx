// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/StoreReplication.h"

#include "Storage/Store/BlockStore.h"

#include <cstddef>

namespace isosurface
{
Status ReplicateStore(FileSystem& files, const std::string& path, const BlockedVolumeHeader& header,
  std::uint32_t store)
{
  const ArrayVariables variables = header.GetVariables();
  const std::string& generation = header.TimeSteps.back().Folder;
  const std::uint32_t stores = header.NumberOfStores;
  const std::vector<std::string> originals =
    BlockStore::ListPaths(GetStoreFolder(files, path, generation, store), variables);
  for (std::uint32_t replica = 1; replica < header.NumberOfReplicas; ++replica)
  {
    const std::string folder = GetReplicaFolder(files, path, generation, store, replica, stores);
    ISOSURFACE_RETURN_IF_ERROR(files.MakeDirectories(folder));
    const std::vector<std::string> copies = BlockStore::ListPaths(folder, variables);
    for (std::size_t file = 0; file < copies.size(); ++file)
    {
      ISOSURFACE_RETURN_IF_ERROR(CopyFile(files, originals[file], files, copies[file]));
    }
    ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(folder));
    ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(
      GetStoreFolder(files, path, generation, FindHost(store, replica, stores))));
  }
  return Status::Ok();
}

} // namespace isosurface
