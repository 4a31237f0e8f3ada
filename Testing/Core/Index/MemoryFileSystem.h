// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemoryFileSystem_h
#define isosurface_MemoryFileSystem_h

#include "Base/FileSystem.h"

#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

/// A disk in memory, whose bytes a test may look at and change, and that fails when asked to.
class MemoryFileSystem : public FileSystem
{
public:
  using Bytes = std::vector<std::uint8_t>;

  std::map<std::string, std::shared_ptr<Bytes>> Files;
  /// Operations that change the disk, and reads, that still succeed; all later ones fail.
  std::uint64_t WritesLeft = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t ReadsLeft = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t Writes = 0;
  std::uint64_t Reads = 0;
  std::uint64_t Created = 0;

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override
  {
    const auto found = this->Files.find(path);
    if (found == this->Files.end())
    {
      return Status(StatusCode::NotFound, path + ": cannot open: no such file");
    }
    return std::unique_ptr<RandomAccessFile>(new ReadableBytes(*this, path, found->second));
  }

  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CountWrite(path));
    ++this->Created;
    auto bytes = std::make_shared<Bytes>();
    this->Files[path] = bytes;
    return std::unique_ptr<WritableFile>(new WritableBytes(*this, path, std::move(bytes)));
  }

  Status Rename(const std::string& from, const std::string& to) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CountWrite(to));
    this->Files[to] = this->Files.at(from);
    this->Files.erase(from);
    return Status::Ok();
  }

  Status MakeDirectories(const std::string&) override { return Status::Ok(); }
  Status RemoveAll(const std::string& path) override
  {
    this->Files.erase(path);
    return Status::Ok();
  }
  bool Exists(const std::string& path) override { return this->Files.count(path) != 0; }
  Result<std::vector<std::string>> List(const std::string&) override
  {
    std::vector<std::string> names;
    for (const auto& file : this->Files)
    {
      names.push_back(file.first);
    }
    return names;
  }
  Status SyncDirectory(const std::string&) override { return Status::Ok(); }

private:
  Status CountWrite(const std::string& path)
  {
    ++this->Writes;
    if (this->WritesLeft == 0)
    {
      return Status(StatusCode::IoError, path + ": cannot write: the test says so");
    }
    --this->WritesLeft;
    return Status::Ok();
  }

  class ReadableBytes : public RandomAccessFile
  {
  public:
    ReadableBytes(MemoryFileSystem& disk, std::string path, std::shared_ptr<Bytes> content)
      : Disk(disk)
      , Path(std::move(path))
      , Content(std::move(content))
    {
    }
    Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
    {
      {
        const std::lock_guard<std::mutex> lock(this->Disk.Mutex);
        ++this->Disk.Reads;
        if (this->Disk.ReadsLeft == 0)
        {
          return Status(StatusCode::IoError, this->Path + ": cannot read: the test says so");
        }
        --this->Disk.ReadsLeft;
      }
      if (offset > this->Content->size() || size > this->Content->size() - offset)
      {
        return Status(StatusCode::Corrupt, this->Path + ": truncated");
      }
      std::memcpy(bytes, this->Content->data() + offset, size);
      return Status::Ok();
    }
    std::uint64_t GetSize() const override { return this->Content->size(); }
    const std::string& GetPath() const override { return this->Path; }

  private:
    MemoryFileSystem& Disk;
    std::string Path;
    std::shared_ptr<Bytes> Content;
  };

  class WritableBytes : public WritableFile
  {
  public:
    WritableBytes(MemoryFileSystem& disk, std::string path, std::shared_ptr<Bytes> content)
      : Disk(disk)
      , Path(std::move(path))
      , Content(std::move(content))
    {
    }
    Status Append(const void* bytes, std::size_t size) override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.CountWrite(this->Path));
      const auto* from = static_cast<const std::uint8_t*>(bytes);
      this->Content->insert(this->Content->end(), from, from + size);
      return Status::Ok();
    }
    Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.CountWrite(this->Path));
      std::memcpy(this->Content->data() + offset, bytes, size);
      return Status::Ok();
    }
    std::uint64_t GetSize() const override { return this->Content->size(); }
    Status SyncAndClose() override { return this->Disk.CountWrite(this->Path); }
    const std::string& GetPath() const override { return this->Path; }

  private:
    MemoryFileSystem& Disk;
    std::string Path;
    std::shared_ptr<Bytes> Content;
  };

  std::mutex Mutex;
};

} // namespace isosurface

#endif
