// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexFileWriter.h"

#include "Coding/EdgeIndex/EdgeIndexEncoder.h"

#include <utility>

namespace isosurface
{
EdgeIndexFileWriter::EdgeIndexFileWriter(
  FileSystem& files, std::string path, const EdgeIndexHeader& header)
  : Files(files)
  , Path(std::move(path))
  , Header(header)
{
  header.Append(this->HeaderBytes);
}

EdgeIndexFileWriter::~EdgeIndexFileWriter()
{
  this->File.reset();
  if (this->Lock)
  {
    // An error cannot be reported here; a partial file is not taken for a complete one.
    static_cast<void>(this->Files.RemoveAll(GetPartialPath(this->Path)));
  }
}

Result<std::unique_ptr<EdgeIndexFileWriter>> EdgeIndexFileWriter::Create(
  FileSystem& files, const std::string& path, const EdgeIndexHeader& header)
{
  ISOSURFACE_RETURN_IF_ERROR(header.Check());
  std::unique_ptr<EdgeIndexFileWriter> writer(new EdgeIndexFileWriter(files, path, header));
  auto lock = LockEdgeIndexFile(files, path);
  ISOSURFACE_RETURN_IF_ERROR(lock.GetStatus());
  writer->Lock = std::move(*lock);
  Result<std::unique_ptr<WritableFile>> file = files.CreateForWriting(GetPartialPath(path));
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  writer->File = std::move(*file);
  ISOSURFACE_RETURN_IF_ERROR(
    writer->File->Append(writer->HeaderBytes.data(), writer->HeaderBytes.size()));
  return writer;
}

Status EdgeIndexFileWriter::Append(const std::uint8_t* records, std::size_t size)
{
  std::vector<std::uint8_t> kept;
  std::size_t used = 0;
  for (std::size_t at = 0; at < size; at += used)
  {
    const Result<EdgeIndexRecord> record =
      EdgeIndexRecord::Parse(this->Header, records + at, size - at, used);
    ISOSURFACE_RETURN_IF_ERROR(record.GetStatus());
    EdgeIndexEntry entry;
    entry.Size = used;
    entry.Block = record->Block;
    (entry.Block.IsPreview ? this->PreviewEntries : this->Entries).push_back(entry);
    std::vector<std::uint8_t>& bytes = entry.Block.IsPreview ? this->Preview : kept;
    bytes.insert(bytes.end(), records + at, records + at + used);
    // Their place in the file must not depend on how many records are appended at a time.
    if (this->Preview.size() >= MaximumPreviewBytes)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->File->Append(kept.data(), kept.size()));
      kept.clear();
      ISOSURFACE_RETURN_IF_ERROR(this->FlushPreview());
    }
  }
  return kept.empty() ? Status::Ok() : this->File->Append(kept.data(), kept.size());
}

Status EdgeIndexFileWriter::FlushPreview()
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

Status EdgeIndexFileWriter::Finish()
{
  ISOSURFACE_RETURN_IF_ERROR(this->FlushPreview());
  std::vector<std::uint8_t> end;
  EdgeIndexDirectory::Append(this->Entries, this->HeaderBytes, end);
  ISOSURFACE_RETURN_IF_ERROR(this->File->Append(end.data(), end.size()));
  ISOSURFACE_RETURN_IF_ERROR(this->File->SyncAndClose());
  this->File.reset();
  return PutEdgeIndexFileInPlace(this->Files, this->Path, this->Lock);
}

Result<std::unique_ptr<PathLock>> LockEdgeIndexFile(FileSystem& files, const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(files.CheckRegular(path, "write"));
  return files.LockFile(EdgeIndexFileWriter::GetPartialPath(path));
}

Status PutEdgeIndexFileInPlace(
  FileSystem& files, const std::string& path, std::unique_ptr<PathLock>& lock)
{
  ISOSURFACE_RETURN_IF_ERROR(files.Rename(EdgeIndexFileWriter::GetPartialPath(path), path));
  lock.reset();
  const std::size_t slash = path.rfind('/');
  return files.SyncDirectory(slash == std::string::npos ? "."
      : slash == 0                                      ? "/"
                                                        : path.substr(0, slash));
}

Status WriteEdgeIndexFile(FileSystem& files, const std::string& path, const EdgeIndexHeader& header,
  BlockSource& source, int threads, const Progress& progress)
{
  EdgeIndexHeader stated = header;
  stated.NumberOfBlocks = source.GetNumberOfBlocks();
  Result<std::unique_ptr<EdgeIndexFileWriter>> writer =
    EdgeIndexFileWriter::Create(files, path, stated);
  ISOSURFACE_RETURN_IF_ERROR(writer.GetStatus());
  ISOSURFACE_RETURN_IF_ERROR(EncodeBlocks(
    stated, source, threads,
    [&writer](const std::vector<std::uint8_t>& records)
    { return (*writer)->Append(records.data(), records.size()); },
    progress));
  return (*writer)->Finish();
}

} // namespace isosurface
