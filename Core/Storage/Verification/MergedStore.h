// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MergedStore_h
#define isosurface_MergedStore_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * A store as its replicas have it together: each page of its directory and trees, and each record,
 * is that of the first replica in which its checksum is right. As a file system it has the files of
 * the store's own folder, for reading alone; so StoreVerification tells whether they are sound.
 * Bytes that no replica has read as those of the first one.
 *
 * The records of a volume in place have no checksums that could be checked without the source: of
 * those only lengths and codings are looked at.
 */
class MergedStore : public FileSystem
{
public:
  /// `header`: of the volume or an overview. `folders`: of the replicas, the most trusted one
  /// first; the first one names the files. The references must outlive this object.
  MergedStore(FileSystem& files, const BlockedVolumeHeader& header, const TimeStepDescription& step,
    std::uint32_t store, std::vector<std::string> folders);

  /// The files, in the order in which a store is written.
  std::vector<std::string> ListNames() const;
  /// The blocks that no replica has, by their numbers in the grid, ascending. Cost: reads all
  /// records once, those of the first replica if they are sound. Errors: if no replica has the
  /// directory.
  Result<std::vector<std::int64_t>> FindLostBlocks();

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override;
  bool Exists(const std::string& path) override;

  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override;
  Status Rename(const std::string& from, const std::string& to) override;
  Status MakeDirectories(const std::string& path) override;
  Status RemoveAll(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& path) override;
  Status SyncDirectory(const std::string& path) override;

private:
  using Files = std::vector<std::unique_ptr<RandomAccessFile>>;

  /// The files of one name, of all replicas; null where there is none.
  Files OpenAll(const std::string& name) const;
  /// The pages of a directory or tree.
  Result<std::unique_ptr<RandomAccessFile>> OpenPages(const std::string& name) const;
  Result<std::unique_ptr<RandomAccessFile>> OpenRecords();
  /// Calls visit(entry) for each block of the directory.
  template <typename Visit>
  Status VisitEntries(const Visit& visit);
  /// The first file in which a block's record is as it was written; files.size() if there is none.
  std::size_t FindIntactFile(const Files& files, const BlockDirectoryEntry& entry) const;
  bool IsIntact(const RandomAccessFile& file, const BlockDirectoryEntry& entry) const;
  std::uint64_t GetRecordSize(const BlockDirectoryEntry& entry) const;

  FileSystem& Disk;
  const StoreDescription& Description;
  ArrayVariables Variables;
  BlockGrid Grid;
  std::size_t Segments;
  SamplePlace Place;
  std::vector<std::string> Folders;
};

/// The faults of one replica of a store of a volume or an overview, in its folder; the samples of a
/// volume in place are not looked at. Cost: reads all of its files once. Memory: as that of
/// VerifyBlockedVolume.
std::vector<Status> CheckStore(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::string& folder, int threads);

/// Ok if the replicas of a store have all of it together, though none may have it alone; else what
/// is lost, in one line with the blocks. `folders`: of the replicas. Cost: reads all of them.
Status CheckReplicas(FileSystem& files, const BlockedVolumeHeader& header,
  const TimeStepDescription& step, std::uint32_t store, const std::vector<std::string>& folders,
  int threads);

} // namespace isosurface

#endif
