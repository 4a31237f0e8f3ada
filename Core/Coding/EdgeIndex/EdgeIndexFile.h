// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexFile_h
#define isosurface_EdgeIndexFile_h

#include "Coding/EdgeIndex/EdgeIndexDirectory.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Surface/Contour/Surface.h"

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
  /// Only blocks that have cells in this box of vertices of the (fine) grid; if the box is flat,
  /// one vertex thick, blocks that it touches.
  std::optional<VertexBox> Box;
  /// Indices of EdgeIndexHeader::Isovalues, in the order of the surface's parts; empty for all of them.
  std::vector<std::size_t> Isovalues;
  /// Piece number Piece of NumberOfPieces of the selection above, with about equal numbers of points.
  int Piece = 0;
  int NumberOfPieces = 1;
};

/**
 * An edge-index file (.eix), opened for reading. Opening reads the header and the directory. Of the
 * records, only those of the selected blocks are read, each once, and decoded in parallel.
 *
 * A file without a valid directory (still being written, cut off, damaged) is read from its start up
 * to the first incomplete record; see IsComplete. The checksum of a record is verified before it is
 * decoded.
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

  /// Differs between files with different headers, or records of other sizes. It does not depend on
  /// the path.
  std::uint64_t GetFingerprint() const;

  bool IsComplete() const { return this->Missing.empty(); }
  /// The missing blocks, as a message for the user; empty if the file is complete.
  const std::string& GetMissing() const { return this->Missing; }

  /// The indices of the selected blocks in GetEntries(). Errors: InvalidArgument.
  Result<std::vector<std::size_t>> Select(const EdgeIndexSelection& selection) const;

  /// Reads a record into `bytes`, which it refers to. Errors: Corrupt, IoError.
  Result<EdgeIndexRecord> ReadRecord(std::size_t entry, std::vector<std::uint8_t>& bytes) const;

  /**
   * The surface of the selected blocks; see JoinIsovalues. GlobalIds are those of the whole surface
   * (for the preview, of its own grid), so that pieces can be joined.
   *
   * Errors: InvalidArgument, Corrupt, IoError, OutOfMemory, Aborted; they name the file. Memory
   * besides the surface: one block for each thread.
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

  std::unique_ptr<RandomAccessFile> File;
  EdgeIndexHeader Header;
  EdgeIndexHeader Preview;
  std::vector<std::uint8_t> HeaderBytes;
  std::vector<EdgeIndexEntry> Entries;
  std::string Missing;
};

} // namespace isosurface

#endif
