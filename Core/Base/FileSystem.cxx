// SPDX-License-Identifier: BSD-3-Clause
#include "Base/FileSystem.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

Status MakeSystemError(const std::string& path, const char* action, int error)
{
  const StatusCode code =
    error == ENOENT || error == ENOTDIR ? StatusCode::NotFound : StatusCode::IoError;
  return Status(code, path + ": cannot " + action + ": " + std::strerror(error));
}

Status MakeSystemError(const std::string& path, const char* action, const std::error_code& error)
{
  return MakeSystemError(path, action, error.value());
}

class LocalRandomAccessFile : public RandomAccessFile
{
public:
  LocalRandomAccessFile(std::string path, int descriptor, std::uint64_t size)
    : Path(std::move(path))
    , Descriptor(descriptor)
    , Size(size)
  {
  }
  LocalRandomAccessFile(const LocalRandomAccessFile&) = delete;
  LocalRandomAccessFile& operator=(const LocalRandomAccessFile&) = delete;
  ~LocalRandomAccessFile() override { ::close(this->Descriptor); }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    auto* to = static_cast<std::uint8_t*>(bytes);
    while (size > 0)
    {
      const ssize_t count = ::pread(this->Descriptor, to, size, static_cast<off_t>(offset));
      if (count < 0)
      {
        if (errno == EINTR)
        {
          continue;
        }
        return MakeSystemError(this->Path, "read", errno);
      }
      if (count == 0)
      {
        return Status(StatusCode::Corrupt,
          this->Path + ": truncated: " + std::to_string(size) + " bytes are missing at offset " +
            std::to_string(offset));
      }
      to += count;
      offset += static_cast<std::uint64_t>(count);
      size -= static_cast<std::size_t>(count);
    }
    return Status::Ok();
  }
  void Prefetch(std::uint64_t offset, std::uint64_t size) const override
  {
    // Only a hint: Read() reports any error.
    static_cast<void>(::posix_fadvise(
      this->Descriptor, static_cast<off_t>(offset), static_cast<off_t>(size), POSIX_FADV_WILLNEED));
  }
  std::uint64_t GetSize() const override { return this->Size; }
  const std::string& GetPath() const override { return this->Path; }

private:
  std::string Path;
  int Descriptor;
  std::uint64_t Size;
};

class LocalWritableFile : public WritableFile
{
public:
  LocalWritableFile(std::string path, int descriptor)
    : Path(std::move(path))
    , Descriptor(descriptor)
  {
  }
  LocalWritableFile(const LocalWritableFile&) = delete;
  LocalWritableFile& operator=(const LocalWritableFile&) = delete;
  ~LocalWritableFile() override { static_cast<void>(this->Close()); }

  Status Append(const void* bytes, std::size_t size) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->WriteAt(this->Size, bytes, size));
    this->Size += size;
    return Status::Ok();
  }

  Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
  {
    const auto* from = static_cast<const std::uint8_t*>(bytes);
    while (size > 0)
    {
      const ssize_t count = ::pwrite(this->Descriptor, from, size, static_cast<off_t>(offset));
      if (count < 0)
      {
        if (errno == EINTR)
        {
          continue;
        }
        return MakeSystemError(this->Path, "write", errno);
      }
      from += count;
      offset += static_cast<std::uint64_t>(count);
      size -= static_cast<std::size_t>(count);
      this->Unsent += static_cast<std::uint64_t>(count);
    }
    this->StartWriteBack();
    return Status::Ok();
  }

  std::uint64_t GetSize() const override { return this->Size; }

  Status SyncAndClose() override
  {
    if (::fsync(this->Descriptor) != 0)
    {
      return MakeSystemError(this->Path, "write to stable storage", errno);
    }
    return this->Close();
  }
  const std::string& GetPath() const override { return this->Path; }

private:
  /// Starts writing to the disk, so that SyncAndClose() does not have to wait for all of it.
  void StartWriteBack()
  {
#if defined(__linux__)
    constexpr std::uint64_t enough = std::uint64_t{ 8 } << 20;
    if (this->Unsent >= enough)
    {
      this->Unsent = 0;
      static_cast<void>(::sync_file_range(this->Descriptor, 0, 0, SYNC_FILE_RANGE_WRITE));
    }
#endif
  }

  Status Close()
  {
    const int descriptor = std::exchange(this->Descriptor, -1);
    if (descriptor >= 0 && ::close(descriptor) != 0)
    {
      return MakeSystemError(this->Path, "close", errno);
    }
    return Status::Ok();
  }

  std::string Path;
  int Descriptor;
  std::uint64_t Size = 0;
  std::uint64_t Unsent = 0; ///< bytes written since write-back was last started
};

class LocalFolderLock : public FolderLock
{
public:
  explicit LocalFolderLock(int descriptor)
    : Descriptor(descriptor)
  {
  }
  LocalFolderLock(const LocalFolderLock&) = delete;
  LocalFolderLock& operator=(const LocalFolderLock&) = delete;
  ~LocalFolderLock() override { ::close(this->Descriptor); }

  bool IsExclusive() const override { return true; }
  /// Whether the path still leads to the locked folder.
  bool IsOf(const std::string& path) const
  {
    struct stat mine = {};
    struct stat there = {};
    return ::fstat(this->Descriptor, &mine) == 0 && ::stat(path.c_str(), &there) == 0 &&
      mine.st_ino == there.st_ino && mine.st_dev == there.st_dev;
  }

private:
  int Descriptor;
};

class LocalFileSystem : public FileSystem
{
public:
  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override
  {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
    {
      return MakeSystemError(path, "open", errno);
    }
    struct stat information = {};
    const bool known = ::fstat(descriptor, &information) == 0;
    if (!known || !S_ISREG(information.st_mode))
    {
      const int error = known ? EISDIR : errno;
      ::close(descriptor);
      return MakeSystemError(path, "open", error);
    }
    return std::unique_ptr<RandomAccessFile>(
      new LocalRandomAccessFile(path, descriptor, static_cast<std::uint64_t>(information.st_size)));
  }

  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor < 0)
    {
      return MakeSystemError(path, "create", errno);
    }
    return std::unique_ptr<WritableFile>(new LocalWritableFile(path, descriptor));
  }

  Result<std::unique_ptr<WritableFile>> OpenForUpdate(const std::string& path) override
  {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor < 0)
    {
      return MakeSystemError(path, "open", errno);
    }
    return std::unique_ptr<WritableFile>(new LocalWritableFile(path, descriptor));
  }

  Status Rename(const std::string& from, const std::string& to) override
  {
    if (::rename(from.c_str(), to.c_str()) != 0)
    {
      return MakeSystemError(to, "put in place", errno);
    }
    return Status::Ok();
  }

  Status MakeDirectories(const std::string& path) override
  {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    return error ? MakeSystemError(path, "create folder", error) : Status::Ok();
  }

  Status MakeNewDirectory(const std::string& path) override
  {
    return ::mkdir(path.c_str(), 0777) == 0 ? Status::Ok()
                                            : MakeSystemError(path, "create folder", errno);
  }

  Status RemoveAll(const std::string& path) override
  {
    std::error_code error;
    std::filesystem::remove_all(path, error);
    return error ? MakeSystemError(path, "remove", error) : Status::Ok();
  }

  bool Exists(const std::string& path) override
  {
    std::error_code error;
    return std::filesystem::exists(path, error);
  }

  Result<std::vector<std::string>> List(const std::string& path) override
  {
    std::vector<std::string> names;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end;
         entry.increment(error))
    {
      names.push_back(entry->path().filename().string());
    }
    if (error && error != std::errc::no_such_file_or_directory)
    {
      return MakeSystemError(path, "list", error);
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  Result<std::unique_ptr<FolderLock>> LockFolder(const std::string& path) override
  {
    for (;;)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->MakeDirectories(path));
      const int descriptor = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      if (descriptor < 0)
      {
        return MakeSystemError(path, "open", errno);
      }
      auto lock = std::make_unique<LocalFolderLock>(descriptor);
      if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
      {
        if (errno == EWOULDBLOCK)
        {
          return Status(
            StatusCode::IoError, path + ": cannot be locked: another program is writing there");
        }
        return std::make_unique<FolderLock>(); // no locks here: NFS, for one, locks no folders
      }
      // The previous holder may have removed the folder; then the lock is worthless.
      if (lock->IsOf(path))
      {
        return std::unique_ptr<FolderLock>(std::move(lock));
      }
    }
  }

  Status SyncDirectory(const std::string& path) override
  {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0)
    {
      return MakeSystemError(path, "open", errno);
    }
    const int failed = ::fsync(descriptor);
    const int error = errno;
    ::close(descriptor);
    return failed != 0 ? MakeSystemError(path, "write to stable storage", error) : Status::Ok();
  }
};

} // namespace

FileSystem& GetLocalFileSystem()
{
  static LocalFileSystem fileSystem;
  return fileSystem;
}

} // namespace isosurface
