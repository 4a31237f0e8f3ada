// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexFileWriter_h
#define isosurface_EdgeIndexFileWriter_h

#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * Writes an edge-index file (.eix): the header, records in the order of appending, and the directory
 * (EdgeIndexDirectory). Until Finish the file has the name GetPartialPath(), from which readers get the
 * complete blocks; then it is renamed. A writer that is destroyed before removes the partial file and
 * leaves an older file as it was. The partial file is locked meanwhile: a second writer to the same
 * path fails at once.
 *
 * Records of the preview are kept in memory until there is 1 MB of them, so that they are adjacent in
 * the file. Memory: these, and about 100 bytes for each record.
 *
 * On one rank, for tests: EdgeIndexWriteJob must write the same bytes.
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

  static std::string GetPartialPath(const std::string& path)
  {
    return GetPartialEdgeIndexPath(path);
  }

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

inline EdgeIndexFileWriter::EdgeIndexFileWriter(
  FileSystem& files, std::string path, const EdgeIndexHeader& header)
  : Files(files)
  , Path(std::move(path))
  , Header(header)
{
  header.Append(this->HeaderBytes);
}

inline EdgeIndexFileWriter::~EdgeIndexFileWriter()
{
  this->File.reset();
  if (this->Lock)
  {
    // An error cannot be reported here; a partial file is not taken for a complete one.
    static_cast<void>(this->Files.RemoveAll(GetPartialPath(this->Path)));
  }
}

inline Result<std::unique_ptr<EdgeIndexFileWriter>> EdgeIndexFileWriter::Create(
  FileSystem& files, const std::string& path, const EdgeIndexHeader& header)
{
  ISOSURFACE_RETURN_IF_ERROR(header.Check());
  std::unique_ptr<EdgeIndexFileWriter> writer(new EdgeIndexFileWriter(files, path, header));
  ISOSURFACE_ASSIGN_OR_RETURN(writer->Lock, LockEdgeIndexFile(files, path));
  ISOSURFACE_ASSIGN_OR_RETURN(writer->File, files.CreateForWriting(GetPartialPath(path)));
  ISOSURFACE_RETURN_IF_ERROR(
    writer->File->Append(writer->HeaderBytes.data(), writer->HeaderBytes.size()));
  return writer;
}

inline Status EdgeIndexFileWriter::Append(const std::uint8_t* records, std::size_t size)
{
  std::vector<std::uint8_t> kept;
  std::size_t used = 0;
  for (std::size_t at = 0; at < size; at += used)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const EdgeIndexRecord record,
      EdgeIndexRecord::Parse(this->Header, records + at, size - at, used));
    EdgeIndexEntry entry;
    entry.Size = used;
    entry.Block = record.Block;
    (entry.Block.IsPreview ? this->PreviewEntries : this->Entries).push_back(entry);
    std::vector<std::uint8_t>& bytes = entry.Block.IsPreview ? this->Preview : kept;
    bytes.insert(bytes.end(), records + at, records + at + used);
    // Their place in the file must not depend on how many records are appended at a time.
    if (this->Preview.size() >= MaximumEdgeIndexPreviewBytes)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->File->Append(kept.data(), kept.size()));
      kept.clear();
      ISOSURFACE_RETURN_IF_ERROR(this->FlushPreview());
    }
  }
  return kept.empty() ? Status::Ok() : this->File->Append(kept.data(), kept.size());
}

inline Status EdgeIndexFileWriter::FlushPreview()
{
  if (!this->Preview.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->File->Append(this->Preview.data(), this->Preview.size()));
  }
  this->Entries.insert(
    this->Entries.end(), this->PreviewEntries.begin(), this->PreviewEntries.end());
  this->PreviewEntries.clear();
  this->Preview.clear();
  return Status::Ok();
}

inline Status EdgeIndexFileWriter::Finish()
{
  ISOSURFACE_RETURN_IF_ERROR(this->FlushPreview());
  std::vector<std::uint8_t> end;
  EdgeIndexDirectory::Append(this->Entries, this->HeaderBytes, end);
  ISOSURFACE_RETURN_IF_ERROR(this->File->Append(end.data(), end.size()));
  ISOSURFACE_RETURN_IF_ERROR(this->File->SyncAndClose());
  this->File.reset();
  return PutEdgeIndexFileInPlace(this->Files, this->Path, this->Lock);
}

/**
 * Writes the surface of a source as a file. The bytes do not depend on the number of threads. The
 * header's NumberOfBlocks is set to that of the source.
 *
 * Errors: InvalidArgument, what Acquire or the file system returns, OutOfMemory, Aborted; an older
 * file stays then. Memory: see EncodeBlocks.
 */
inline Status WriteEdgeIndexFile(FileSystem& files, const std::string& path,
  const EdgeIndexHeader& header, BlockSource& source, int threads, const Progress& progress = {})
{
  EdgeIndexHeader stated = header;
  stated.NumberOfBlocks = source.GetNumberOfBlocks();
  ISOSURFACE_ASSIGN_OR_RETURN(
    std::unique_ptr<EdgeIndexFileWriter> writer, EdgeIndexFileWriter::Create(files, path, stated));
  ISOSURFACE_RETURN_IF_ERROR(EncodeBlocks(
    stated, source, threads,
    [&writer](const std::vector<std::uint8_t>& records)
    { return writer->Append(records.data(), records.size()); },
    progress));
  return writer->Finish();
}

} // namespace isosurface

#endif
