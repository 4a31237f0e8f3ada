// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_MemoryDisk_h
#define isosurface_Testing_MemoryDisk_h

#include "Ground/Base/FileSystem.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/// A disk in memory, with folders, for several threads. A test looks at its bytes and changes them;
/// it counts operations, and fails from a given one on. A path without a slash is always writable.
class MemoryDisk : public FileSystem
{
public:
  using Bytes = std::vector<std::uint8_t>;
  static constexpr std::uint64_t Never = std::numeric_limits<std::uint64_t>::max();

  /// A file's bytes, to look at or to damage.
  Bytes& GetFile(const std::string& path) { return *this->Files.at(path); }
  /// Makes or replaces a file, whether the disk fails or not.
  void SetFile(const std::string& path, Bytes bytes)
  {
    this->Files[path] = std::make_shared<Bytes>(std::move(bytes));
  }
  const std::map<std::string, std::shared_ptr<Bytes>>& GetFiles() const { return this->Files; }
  /// Sets when a file was modified; 1 if nobody does.
  void SetModified(const std::string& path, std::int64_t time) { this->Times[path] = time; }
  /// The names of all files, each with its contents.
  std::map<std::string, Bytes> Copy() const
  {
    std::map<std::string, Bytes> copy;
    for (const auto& file : this->Files)
    {
      copy[file.first] = *file.second;
    }
    return copy;
  }
  const std::set<std::string>& GetFolders() const { return this->Folders; }

  /// Lets `write` operations that change the disk succeed; all later ones fail.
  void FailFromWrite(std::uint64_t write)
  {
    this->Writes = 0;
    this->FirstFailingWrite = write;
  }
  /// Lets `read` reads succeed; all later ones fail.
  void FailFromRead(std::uint64_t read)
  {
    this->Reads = 0;
    this->FirstFailingRead = read;
  }
  /// Calls a function before each read, by the thread that reads.
  void SetBeforeRead(std::function<void()> call) { this->BeforeRead = std::move(call); }
  void SetFreeBytes(std::uint64_t bytes) { this->FreeBytes = bytes; }
  std::optional<std::uint64_t> FindFreeBytes(const std::string&) override
  {
    return this->FreeBytes;
  }
  std::uint64_t GetWrites() const { return this->Writes; }
  std::uint64_t GetCreatedFiles() const { return this->CreatedFiles; }
  std::uint64_t GetBytesRead(const std::string& nameEnd) const
  {
    std::uint64_t sum = 0;
    for (const auto& count : this->BytesRead)
    {
      const std::string& path = count.first;
      sum += path.size() >= nameEnd.size() &&
          path.compare(path.size() - nameEnd.size(), nameEnd.size(), nameEnd) == 0
        ? count.second
        : 0;
    }
    return sum;
  }
  std::uint64_t GetReads() const { return this->Reads; }

  /// One call for bytes of a file.
  struct Access
  {
    std::string Path;
    std::uint64_t Begin;
    std::uint64_t End;
    bool IsPrefetch;
  };
  /// Reads and prefetches of files of one name, in the order of the calls.
  std::vector<Access> GetAccesses(const std::string& nameEnd) const
  {
    std::vector<Access> found;
    std::copy_if(this->Accesses.begin(), this->Accesses.end(), std::back_inserter(found),
      [&](const Access& access)
      {
        return access.Path.size() >= nameEnd.size() &&
          access.Path.compare(access.Path.size() - nameEnd.size(), nameEnd.size(), nameEnd) == 0;
      });
    return found;
  }

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto found = this->Files.find(path);
    if (found == this->Files.end())
    {
      return Status(StatusCode::NotFound, path + ": cannot open: No such file");
    }
    return std::unique_ptr<RandomAccessFile>(new Reader(*this, path, found->second));
  }
  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    ISOSURFACE_RETURN_IF_ERROR(this->CountWrite(path));
    const std::size_t folderEnd = path.rfind('/');
    if (folderEnd != std::string::npos && this->Folders.count(path.substr(0, folderEnd)) == 0)
    {
      return Status(StatusCode::NotFound, path + ": cannot create: No such folder");
    }
    ++this->CreatedFiles;
    auto bytes = std::make_shared<Bytes>();
    this->Files[path] = bytes;
    return std::unique_ptr<WritableFile>(new Writer(*this, path, bytes));
  }
  Result<std::unique_ptr<WritableFile>> OpenForUpdate(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto found = this->Files.find(path);
    if (found == this->Files.end())
    {
      return Status(StatusCode::NotFound, path + ": cannot open: No such file");
    }
    return std::unique_ptr<WritableFile>(new Writer(*this, path, found->second));
  }
  Result<std::unique_ptr<WritableFile>> OpenForAppending(
    const std::string& path, std::uint64_t size) override
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto file, this->OpenForUpdate(path));
    const std::lock_guard<std::mutex> lock(this->Mutex);
    ISOSURFACE_RETURN_IF_ERROR(this->CountWrite(path));
    Bytes& bytes = *this->Files.at(path);
    if (size > bytes.size())
    {
      return Status(StatusCode::Corrupt, path + ": truncated");
    }
    bytes.resize(static_cast<std::size_t>(size));
    return file;
  }
  Status Rename(const std::string& from, const std::string& to) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    ISOSURFACE_RETURN_IF_ERROR(this->CountWrite(to));
    this->Files[to] = this->Files.at(from);
    this->Files.erase(from);
    return Status::Ok();
  }
  Status MakeDirectories(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    ISOSURFACE_RETURN_IF_ERROR(this->CountWrite(path));
    for (std::size_t end = path.find('/', 1); end != std::string::npos;
         end = path.find('/', end + 1))
    {
      this->Folders.insert(path.substr(0, end));
    }
    this->Folders.insert(path);
    return Status::Ok();
  }
  Status RemoveAll(const std::string& path) override
  {
    // Removing needs no space: it works on a full disk.
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto isWithin = [&](const std::string& name)
    { return name == path || name.compare(0, path.size() + 1, path + "/") == 0; };
    for (auto file = this->Files.begin(); file != this->Files.end();)
    {
      file = isWithin(file->first) ? this->Files.erase(file) : std::next(file);
    }
    for (auto folder = this->Folders.begin(); folder != this->Folders.end();)
    {
      folder = isWithin(*folder) ? this->Folders.erase(folder) : std::next(folder);
    }
    return Status::Ok();
  }
  bool Exists(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    return this->Files.count(path) + this->Folders.count(path) > 0;
  }
  Result<std::vector<std::string>> List(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    std::set<std::string> names;
    const auto add = [&](const std::string& name)
    {
      if (name.compare(0, path.size() + 1, path + "/") == 0)
      {
        const std::string rest = name.substr(path.size() + 1);
        names.insert(rest.substr(0, rest.find('/')));
      }
    };
    for (const auto& file : this->Files)
    {
      add(file.first);
    }
    for (const std::string& folder : this->Folders)
    {
      add(folder);
    }
    return std::vector<std::string>(names.begin(), names.end());
  }
  Result<FileState> FindState(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    FileState state;
    for (const auto& file : this->Files)
    {
      if (file.first == path || file.first.compare(0, path.size() + 1, path + "/") == 0)
      {
        const auto time = this->Times.find(file.first);
        state.Modified = std::max(state.Modified, time == this->Times.end() ? 1 : time->second);
        state.Bytes += file.second->size();
        ++state.Files;
      }
    }
    return state;
  }
  Status SyncDirectory(const std::string& path) override
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    return this->CountWrite(path);
  }

private:
  Status CountWrite(const std::string& path)
  {
    if (this->Writes++ >= this->FirstFailingWrite)
    {
      return Status(StatusCode::IoError, path + ": cannot write: No space left on device");
    }
    return Status::Ok();
  }

  class Reader : public RandomAccessFile
  {
  public:
    Reader(MemoryDisk& disk, std::string path, std::shared_ptr<const Bytes> content)
      : Disk(disk)
      , Path(std::move(path))
      , Content(std::move(content))
    {
    }
    Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
    {
      if (this->Disk.BeforeRead)
      {
        this->Disk.BeforeRead();
      }
      const std::lock_guard<std::mutex> lock(this->Disk.Mutex);
      if (this->Disk.Reads++ >= this->Disk.FirstFailingRead)
      {
        return Status(StatusCode::IoError, this->Path + ": cannot read: Input/output error");
      }
      this->Disk.BytesRead[this->Path] += size;
      this->Disk.Accesses.push_back({ this->Path, offset, offset + size, false });
      if (offset > this->Content->size() || size > this->Content->size() - offset)
      {
        return Status(StatusCode::Corrupt, this->Path + ": truncated");
      }
      if (size > 0)
      {
        std::memcpy(bytes, this->Content->data() + offset, size);
      }
      return Status::Ok();
    }
    void Prefetch(std::uint64_t offset, std::uint64_t size) const override
    {
      const std::lock_guard<std::mutex> lock(this->Disk.Mutex);
      this->Disk.Accesses.push_back({ this->Path, offset, offset + size, true });
    }
    std::uint64_t GetSize() const override { return this->Content->size(); }
    const std::string& GetPath() const override { return this->Path; }

  private:
    MemoryDisk& Disk;
    std::string Path;
    std::shared_ptr<const Bytes> Content;
  };

  class Writer : public WritableFile
  {
  public:
    Writer(MemoryDisk& disk, std::string path, std::shared_ptr<Bytes> content)
      : Disk(disk)
      , Path(std::move(path))
      , Content(std::move(content))
    {
    }
    Status Append(const void* bytes, std::size_t size) override
    {
      return this->WriteAt(this->Content->size(), bytes, size);
    }
    Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
    {
      const std::lock_guard<std::mutex> lock(this->Disk.Mutex);
      ISOSURFACE_RETURN_IF_ERROR(this->Disk.CountWrite(this->Path));
      this->Content->resize(std::max<std::size_t>(this->Content->size(), offset + size));
      if (size > 0)
      {
        std::memcpy(this->Content->data() + offset, bytes, size);
      }
      return Status::Ok();
    }
    std::uint64_t GetSize() const override { return this->Content->size(); }
    Status Sync() override
    {
      const std::lock_guard<std::mutex> lock(this->Disk.Mutex);
      return this->Disk.CountWrite(this->Path);
    }
    Status SyncAndClose() override { return this->Sync(); }
    const std::string& GetPath() const override { return this->Path; }

  private:
    MemoryDisk& Disk;
    std::string Path;
    std::shared_ptr<Bytes> Content;
  };

  std::function<void()> BeforeRead;
  std::mutex Mutex;
  std::map<std::string, std::shared_ptr<Bytes>> Files;
  std::map<std::string, std::int64_t> Times;
  std::set<std::string> Folders{ "/data" };
  std::map<std::string, std::uint64_t> BytesRead;
  std::vector<Access> Accesses;
  std::uint64_t Reads = 0;
  std::optional<std::uint64_t> FreeBytes;
  std::uint64_t Writes = 0;
  std::uint64_t CreatedFiles = 0;
  std::uint64_t FirstFailingRead = Never;
  std::uint64_t FirstFailingWrite = Never;
};

} // namespace isosurface

#endif
