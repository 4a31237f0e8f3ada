// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/StoreReplication.h"

#include "Storage/Store/BlockStore.h"

#include <algorithm>
#include <cstddef>

namespace isosurface
{
namespace
{

constexpr std::uint64_t CopiedBytes = std::uint64_t{ 1 } << 20;

} // namespace

Status CopyStoreFile(
  FileSystem& files, const std::string& from, FileSystem& toFiles, const std::string& to)
{
  const auto source = files.OpenForReading(from);
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  const auto copy = toFiles.CreateForWriting(to);
  ISOSURFACE_RETURN_IF_ERROR(copy.GetStatus());
  const std::uint64_t size = (*source)->GetSize();
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t begin = 0; begin < size; begin += bytes.size())
  {
    bytes.resize(static_cast<std::size_t>(std::min(CopiedBytes, size - begin)));
    ISOSURFACE_RETURN_IF_ERROR((*source)->Read(begin, bytes.size(), bytes.data()));
    ISOSURFACE_RETURN_IF_ERROR((*copy)->Append(bytes.data(), bytes.size()));
  }
  return (*copy)->SyncAndClose();
}

Status ReplicateStore(FileSystem& files, const std::string& path, const BlockedVolumeHeader& header,
  std::uint32_t store)
{
  const ArrayVariables variables = header.GetVariables();
  const std::string& generation = header.TimeSteps.back().Folder;
  const std::uint32_t stores = header.NumberOfStores;
  const std::vector<std::string> originals =
    BlockStore::ListPaths(GetStoreFolder(path, generation, store), variables);
  for (std::uint32_t replica = 1; replica < header.NumberOfReplicas; ++replica)
  {
    const std::string folder = GetReplicaFolder(path, generation, store, replica, stores);
    ISOSURFACE_RETURN_IF_ERROR(files.MakeDirectories(folder));
    const std::vector<std::string> copies = BlockStore::ListPaths(folder, variables);
    for (std::size_t file = 0; file < copies.size(); ++file)
    {
      ISOSURFACE_RETURN_IF_ERROR(CopyStoreFile(files, originals[file], files, copies[file]));
    }
    ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(folder));
    ISOSURFACE_RETURN_IF_ERROR(
      files.SyncDirectory(GetStoreFolder(path, generation, FindHost(store, replica, stores))));
  }
  return Status::Ok();
}

} // namespace isosurface
