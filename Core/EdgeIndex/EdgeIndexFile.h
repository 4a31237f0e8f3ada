// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexFile_h
#define isosurface_EdgeIndexFile_h

#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "EdgeIndex/EdgeIndexDirectory.h"
#include "EdgeIndex/EdgeIndexHeader.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Which blocks of an edge-index file to read.
struct EdgeIndexSelection
{
  /// The coarse preview instead of the surface.
  bool Preview = false;
  /// Blocks that have cells in this box of vertices of the (fine) grid, or that it cuts if it is
  /// flat. All blocks otherwise.
  std::optional<VertexBox> Box;
  /// Places in EdgeIndexHeader::Isovalues; empty for all of them.
  std::vector<std::size_t> Isovalues;
  /// Of what is selected so far, one of so many parts with about as many points each.
  int Piece = 0;
  int NumberOfPieces = 1;
};

/**
 * An edge-index file (.eix), opened for reading. Opening reads the header and the directory; of the
 * rest only the records of the blocks that are asked for are read, each once, and decoded in
 * parallel.
 *
 * A file that is still being written, or was cut off, or whose directory is damaged, is read from
 * the begin up to the first record that is not complete; see IsComplete. Every record has a
 * checksum, which is looked at before anything is decoded.
 */
class EdgeIndexFile
{
public:
  /// Errors: what the file system returns, Corrupt (not such a file), Unsupported, OutOfMemory. The
  /// file system must outlive the file.
  static Result<std::unique_ptr<EdgeIndexFile>> Open(FileSystem& files, const std::string& path);

  const EdgeIndexHeader& GetHeader() const { return this->Header; }
  /// In the order of the file.
  const std::vector<EdgeIndexEntry>& GetEntries() const { return this->Entries; }
  const std::string& GetPath() const { return this->File->GetPath(); }
  std::uint64_t GetSize() const { return this->File->GetSize(); }

  bool IsComplete() const { return this->Missing.empty(); }
  /// What is missing, in a sentence for the user; empty if the file is complete.
  const std::string& GetMissing() const { return this->Missing; }

  /// The places of the selected blocks in GetEntries(). Errors: InvalidArgument.
  Result<std::vector<std::size_t>> Select(const EdgeIndexSelection& selection) const;

  /// Reads a record into `bytes`, to which it refers. Errors: Corrupt, IoError.
  Result<EdgeIndexRecord> ReadRecord(std::size_t entry, std::vector<std::uint8_t>& bytes) const;

  /**
   * The surface of the selected blocks; see DecodeSurface. GlobalIds are those of the whole surface
   * (of the preview: in its own grid), so that pieces can be joined.
   *
   * Errors: InvalidArgument, Corrupt, IoError, OutOfMemory, Aborted; they name the file. Memory
   * beside the surface: a block a thread.
   */
  Result<Surface> Read(const EdgeIndexSelection& selection, const ContourRequest& request,
    int threads, const Progress& progress = {}) const;

  /// Reads and decodes every block. Corrupt also if the file is not complete.
  Status Verify(int threads, const Progress& progress = {}) const;

private:
  EdgeIndexFile(std::unique_ptr<RandomAccessFile> file, EdgeIndexHeader header,
    std::vector<std::uint8_t> headerBytes);
  Status ReadDirectory();
  Status ScanRecords();
  Status NameFile(const Status& status) const;
  Result<Surface> ReadWithinMemory(const EdgeIndexSelection& selection,
    const ContourRequest& request, int threads, const Progress& progress) const;

  std::unique_ptr<RandomAccessFile> File;
  EdgeIndexHeader Header;
  EdgeIndexHeader Preview;
  std::vector<std::uint8_t> HeaderBytes;
  std::vector<EdgeIndexEntry> Entries;
  std::string Missing;
};

} // namespace isosurface

#endif
