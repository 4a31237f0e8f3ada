// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexFileWriter_h
#define isosurface_EdgeIndexFileWriter_h

#include "Coding/EdgeIndex/EdgeIndexDirectory.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Writes an edge-index file (.eix): the header, records in the order of appending, and the directory
 * (EdgeIndexDirectory). Until Finish the file has the name GetPartialPath, from which readers get the
 * complete blocks; then it is renamed. A writer that is destroyed before removes the partial file and
 * leaves an older file as it was. The partial file is locked meanwhile: a second writer to the same
 * path fails at once.
 *
 * Records of the preview are kept in memory until there is 1 MB of them, so that they are adjacent in
 * the file. Memory: these, and about 100 bytes for each record.
 *
 * For tests and benchmarks, on one rank; the VTK writer has EdgeIndexWriteJob.
 */
class EdgeIndexFileWriter
{
public:
  /// Errors: InvalidArgument, what the file system returns; IoError if another program writes there.
  static Result<std::unique_ptr<EdgeIndexFileWriter>> Create(
    FileSystem& files, const std::string& path, const EdgeIndexHeader& header);
  ~EdgeIndexFileWriter();
  EdgeIndexFileWriter(const EdgeIndexFileWriter&) = delete;
  EdgeIndexFileWriter& operator=(const EdgeIndexFileWriter&) = delete;

  /// Appends records of any number of blocks, whole, from an encoder with the same header. Errors:
  /// Corrupt, what the file system returns.
  Status Append(const std::uint8_t* records, std::size_t size);

  /// Writes the directory and renames the file. Nothing may follow.
  Status Finish();

  /// Records of the preview are written when they reach this size.
  static constexpr std::size_t MaximumPreviewBytes = std::size_t{ 1 } << 20;

  static std::string GetPartialPath(const std::string& path) { return path + ".part"; }

private:
  EdgeIndexFileWriter(FileSystem& files, std::string path, const EdgeIndexHeader& header);
  Status FlushPreview();

  FileSystem& Files;
  std::string Path;
  EdgeIndexHeader Header;
  std::vector<std::uint8_t> HeaderBytes;
  std::unique_ptr<PathLock> Lock; ///< of the partial file, until it is complete or removed
  std::unique_ptr<WritableFile> File;
  std::vector<EdgeIndexEntry> Entries;
  std::vector<EdgeIndexEntry> PreviewEntries; ///< of Preview
  std::vector<std::uint8_t> Preview;
};

/// Locks the partial file of `path`, which is the first step of writing. Errors: those of LockFile;
/// IoError if what is at the path is no regular file.
Result<std::unique_ptr<PathLock>> LockEdgeIndexFile(FileSystem& files, const std::string& path);

/// Renames a complete file from GetPartialPath(path) to `path`, durably. Releases the lock as soon as
/// it is renamed: from then on a partial file is another writer's.
Status PutEdgeIndexFileInPlace(
  FileSystem& files, const std::string& path, std::unique_ptr<PathLock>& lock);

/**
 * Writes the surface of a source as a file. The bytes do not depend on the number of threads. The
 * header's NumberOfBlocks is set to that of the source.
 *
 * Errors: InvalidArgument, what Acquire or the file system returns, OutOfMemory, Aborted; an older
 * file stays then. Memory: see EncodeBlocks.
 */
Status WriteEdgeIndexFile(FileSystem& files, const std::string& path, const EdgeIndexHeader& header,
  BlockSource& source, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
