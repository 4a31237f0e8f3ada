// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexFileWriter_h
#define isosurface_EdgeIndexFileWriter_h

#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "EdgeIndex/EdgeIndexDirectory.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Writes an edge-index file (.eix): the header, records as they come, and at the end the directory
 * (EdgeIndexDirectory). Until then it stands beside its place (GetPartialPath), where a reader
 * finds the blocks that are complete; then it comes to its place in one step. A writer that is
 * dropped before leaves what was at the place as it was, and removes its own.
 *
 * Blocks of the preview are kept back until there is 1 MB of them, so that they stand together.
 * Memory: that, and about 100 bytes a record.
 */
class EdgeIndexFileWriter
{
public:
  /// Errors: InvalidArgument, what the file system returns.
  static Result<std::unique_ptr<EdgeIndexFileWriter>> Create(
    FileSystem& files, const std::string& path, const EdgeIndexHeader& header);
  ~EdgeIndexFileWriter();
  EdgeIndexFileWriter(const EdgeIndexFileWriter&) = delete;
  EdgeIndexFileWriter& operator=(const EdgeIndexFileWriter&) = delete;

  /// Appends whole records (EdgeIndexEncoder::EncodeBlock), of any number of blocks, made by an
  /// encoder with the same header. Errors: Corrupt, what the file system returns.
  Status Append(const std::uint8_t* records, std::size_t size);

  /// Completes the file. Nothing may follow.
  Status Finish();

  /// So many bytes of the preview are kept back.
  static constexpr std::size_t MaximumPreviewBytes = std::size_t{ 1 } << 20;

  static std::string GetPartialPath(const std::string& path) { return path + ".part"; }

private:
  EdgeIndexFileWriter(FileSystem& files, std::string path, const EdgeIndexHeader& header);
  Status FlushPreview();

  FileSystem& Files;
  std::string Path;
  EdgeIndexHeader Header;
  std::vector<std::uint8_t> HeaderBytes;
  std::unique_ptr<WritableFile> File;
  std::vector<EdgeIndexEntry> Entries;
  std::vector<EdgeIndexEntry> PreviewEntries; ///< of what is kept back
  std::vector<std::uint8_t> Preview;
};

/// Brings a complete file from GetPartialPath(path) to its place, in one step and durably.
Status PutEdgeIndexFileInPlace(FileSystem& files, const std::string& path);

/**
 * The surface of a source as a file, encoded by `threads` threads; equal bytes for any number. The
 * header's NumberOfBlocks is set to the source's.
 *
 * Errors: InvalidArgument, what Acquire or the file system returns, OutOfMemory, Aborted; there is
 * no file then, or the one that was. Memory: see EncodeBlocks.
 */
Status WriteEdgeIndexFile(FileSystem& files, const std::string& path, const EdgeIndexHeader& header,
  BlockSource& source, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
