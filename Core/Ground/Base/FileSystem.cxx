// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/FileSystem.h"

#include "Ground/Base/DescriptorPool.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Base/RemoteFileSystem.h"
#include "Ground/Base/UsedFileSystem.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
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

int Synchronise(int descriptor)
{
  int failed = 0;
  do
  {
    failed = ::fsync(descriptor);
  } while (failed != 0 && errno == EINTR);
  return failed;
}

class LocalRandomAccessFile : public RandomAccessFile
{
public:
  explicit LocalRandomAccessFile(std::unique_ptr<PooledFile> file)
    : File(std::move(file))
  {
  }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    if (ReadingStop::IsWanted())
    {
      return Status(StatusCode::Aborted, this->GetPath() + ": reading was stopped");
    }
    auto descriptor = this->File->Use();
    ISOSURFACE_RETURN_IF_ERROR(descriptor.GetStatus());
    bool isRenewed = false;
    auto* to = static_cast<std::uint8_t*>(bytes);
    while (size > 0)
    {
      const ssize_t count = ::pread((*descriptor)->Get(), to, size, static_cast<off_t>(offset));
      if (count < 0)
      {
        if (errno == EINTR)
        {
          continue;
        }
        if (errno == ESTALE && !isRenewed)
        {
          isRenewed = true;
          descriptor = this->File->Renew(*descriptor);
          ISOSURFACE_RETURN_IF_ERROR(descriptor.GetStatus());
          continue;
        }
        return MakeSystemError(this->GetPath(), "read", errno);
      }
      if (count == 0)
      {
        return Status(StatusCode::Corrupt,
          this->GetPath() + ": truncated: " + std::to_string(size) +
            " bytes are missing at offset " + std::to_string(offset));
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
    const auto descriptor = this->File->Use();
    if (descriptor.IsOk())
    {
      static_cast<void>(::posix_fadvise((*descriptor)->Get(), static_cast<off_t>(offset),
        static_cast<off_t>(size), POSIX_FADV_WILLNEED));
    }
  }
  std::uint64_t GetSize() const override { return this->File->GetSize(); }
  const std::string& GetPath() const override { return this->File->GetPath(); }

private:
  std::unique_ptr<PooledFile> File;
};

class LocalWritableFile : public WritableFile
{
public:
  explicit LocalWritableFile(std::unique_ptr<PooledFile> file)
    : Path(file->GetPath())
    , File(std::move(file))
  {
  }

  /// Cuts off what is beyond so many bytes; then Append() goes on there.
  Status CutTo(std::uint64_t size)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto descriptor, this->File->Use());
    if (size > this->File->GetSize())
    {
      return Status(StatusCode::Corrupt, this->Path + ": truncated");
    }
    if (::ftruncate(descriptor->Get(), static_cast<off_t>(size)) != 0)
    {
      return MakeSystemError(this->Path, "write", errno);
    }
    this->Size = size;
    return Status::Ok();
  }

  Status Append(const void* bytes, std::size_t size) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->WriteAt(this->Size, bytes, size));
    this->Size += size;
    return Status::Ok();
  }

  Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto descriptor, this->File->Use());
    const auto* from = static_cast<const std::uint8_t*>(bytes);
    while (size > 0)
    {
      const ssize_t count = ::pwrite(descriptor->Get(), from, size, static_cast<off_t>(offset));
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
    this->StartWriteBack(*descriptor);
    return Status::Ok();
  }

  std::uint64_t GetSize() const override { return this->Size; }

  Status Sync() override
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto descriptor, this->File->Use());
    return Synchronise(descriptor->Get()) != 0
      ? MakeSystemError(this->Path, "write to stable storage", errno)
      : Status::Ok();
  }

  Status SyncAndClose() override
  {
    Status synced = this->Sync();
    this->File.reset();
    return synced;
  }
  const std::string& GetPath() const override { return this->Path; }

private:
  /// Starts writing to the disk, so that SyncAndClose() does not have to wait for all of it.
  void StartWriteBack(const Descriptor& descriptor)
  {
#if defined(__linux__)
    constexpr std::uint64_t enough = std::uint64_t{ 8 } << 20;
    if (this->Unsent >= enough)
    {
      this->Unsent = 0;
      static_cast<void>(::sync_file_range(descriptor.Get(), 0, 0, SYNC_FILE_RANGE_WRITE));
    }
#else
    static_cast<void>(descriptor);
#endif
  }

  std::string Path;
  std::unique_ptr<PooledFile> File; ///< null when it is closed
  std::uint64_t Size = 0;
  std::uint64_t Unsent = 0; ///< bytes written since write-back was last started
};

class LocalPathLock : public PathLock
{
public:
  explicit LocalPathLock(int descriptor)
    : Descriptor(descriptor)
  {
  }
  LocalPathLock(const LocalPathLock&) = delete;
  LocalPathLock& operator=(const LocalPathLock&) = delete;
  ~LocalPathLock() override { ::close(this->Descriptor); }

  bool IsExclusive() const override { return true; }
  /// Whether the path still leads to what is locked.
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

/// Removes a name that leads to a file of another name, by a symbolic or a hard link: somebody else may
/// have put it where a file is about to be written.
Status RemoveLink(const std::string& path)
{
  struct stat there = {};
  const bool isLink = ::lstat(path.c_str(), &there) == 0 &&
    (S_ISLNK(there.st_mode) || (S_ISREG(there.st_mode) && there.st_nlink > 1));
  return isLink && ::unlink(path.c_str()) != 0 ? MakeSystemError(path, "remove the link", errno)
                                               : Status::Ok();
}

/// Adds the state of a file, or of all files in a folder. Returns the system's error, or 0.
int AddState(const std::string& path, FileState& state)
{
  struct stat there = {};
  if (::stat(path.c_str(), &there) != 0)
  {
    return errno;
  }
  if (!S_ISDIR(there.st_mode))
  {
    constexpr std::uint64_t nanoseconds = 1000000000;
    // Unsigned, since a time beyond the year 2262 wraps.
    const auto modified =
      static_cast<std::int64_t>(static_cast<std::uint64_t>(there.st_mtim.tv_sec) * nanoseconds +
        static_cast<std::uint64_t>(there.st_mtim.tv_nsec));
    state.Modified = state.Files == 0 ? modified : std::max(state.Modified, modified);
    state.Bytes += static_cast<std::uint64_t>(there.st_size);
    ++state.Files;
    return 0;
  }
  std::error_code error;
  for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end;
       entry.increment(error))
  {
    // Links to folders could lead in circles.
    const bool isLinkedFolder = entry->is_symlink(error) && entry->is_directory(error);
    const int inside = isLinkedFolder ? 0 : AddState(entry->path().string(), state);
    if (inside != 0 && inside != ENOENT && inside != ELOOP) // whoever reads a link tells what it is
    {
      return inside;
    }
  }
  return error.value();
}

class LocalFileSystem : public FileSystem
{
public:
  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override
  {
    if (IsAddress(path))
    {
      return RemoteFileSystem::Get().OpenForReading(path);
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto file, PooledFile::Open(this->Descriptors, path, O_RDONLY, "open"));
    return std::unique_ptr<RandomAccessFile>(new LocalRandomAccessFile(std::move(file)));
  }

  Result<std::unique_ptr<RandomAccessFile>> OpenPart(
    const std::string& path, std::int64_t bytes) override
  {
    return IsAddress(path) ? RemoteFileSystem::Get().OpenPart(path, bytes)
                           : this->OpenForReading(path);
  }

  void LookFor(const std::vector<std::string>& paths) override
  {
    if (!paths.empty() && IsAddress(paths.front()))
    {
      RemoteFileSystem::Get().LookFor(paths);
    }
  }

  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    ISOSURFACE_RETURN_IF_ERROR(RemoveLink(path));
    return this->OpenForWriting(path, O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW, "create");
  }

  Result<std::unique_ptr<WritableFile>> OpenForUpdate(const std::string& path) override
  {
    return this->OpenForWriting(path, O_RDWR | O_NOFOLLOW, "open");
  }

  Result<std::unique_ptr<WritableFile>> OpenForAppending(
    const std::string& path, std::uint64_t size) override
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto file, PooledFile::Open(this->Descriptors, path, O_RDWR | O_NOFOLLOW, "open"));
    auto writable = std::make_unique<LocalWritableFile>(std::move(file));
    ISOSURFACE_RETURN_IF_ERROR(writable->CutTo(size));
    return std::unique_ptr<WritableFile>(std::move(writable));
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
    if (IsAddress(path))
    {
      return RemoteFileSystem::Get().MakeDirectories(path);
    }
    std::error_code error;
    std::filesystem::create_directories(path, error);
    return error ? MakeSystemError(path, "create folder", error.value()) : Status::Ok();
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
    return error ? MakeSystemError(path, "remove", error.value()) : Status::Ok();
  }

  bool Exists(const std::string& path) override
  {
    if (IsAddress(path))
    {
      return RemoteFileSystem::Get().Exists(path);
    }
    // What nobody may look at is told by whoever opens it.
    std::error_code error;
    return std::filesystem::exists(path, error) || error == std::errc::permission_denied;
  }

  Result<std::vector<std::string>> List(const std::string& path) override
  {
    std::vector<std::string> names;
    if (IsAddress(path))
    {
      return names;
    }
    std::error_code error;
    for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end;
         entry.increment(error))
    {
      names.push_back(entry->path().filename().string());
    }
    if (error && error != std::errc::no_such_file_or_directory)
    {
      return MakeSystemError(path, "list", error.value());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  Result<FileState> FindState(const std::string& path) override
  {
    if (IsAddress(path))
    {
      return RemoteFileSystem::Get().FindState(path);
    }
    FileState state;
    const int error = AddState(path, state);
    return error != 0 ? Result<FileState>(MakeSystemError(path, "look at", error)) : state;
  }

  std::optional<std::uint64_t> FindFreeBytes(const std::string& path) override
  {
    std::error_code error;
    std::filesystem::path folder = std::filesystem::absolute(path, error);
    while (!error && !std::filesystem::is_directory(folder, error) && folder.has_relative_path())
    {
      folder = folder.parent_path();
      error.clear();
    }
    const std::filesystem::space_info space = std::filesystem::space(folder, error);
    return error ? std::nullopt : std::optional<std::uint64_t>(space.available);
  }

  Result<std::unique_ptr<PathLock>> LockFolder(const std::string& path) override
  {
    for (;;)
    {
      std::error_code error;
      if (std::filesystem::is_symlink(path, error))
      {
        return Status(StatusCode::IoError,
          path + ": cannot be locked: it is a link, and nothing is written through one");
      }
      ISOSURFACE_RETURN_IF_ERROR(this->MakeDirectories(path));
      auto lock = this->TryToLock(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW);
      if (!lock.IsOk() || *lock)
      {
        return lock;
      }
    }
  }

  Result<std::unique_ptr<PathLock>> LockFile(const std::string& path) override
  {
    for (;;)
    {
      ISOSURFACE_RETURN_IF_ERROR(RemoveLink(path));
      ISOSURFACE_RETURN_IF_ERROR(CheckRegularFile(path, "create"));
      auto lock = this->TryToLock(path, O_RDWR | O_CREAT | O_NONBLOCK | O_NOFOLLOW);
      if (!lock.IsOk() || *lock)
      {
        return lock;
      }
    }
  }

  Status CheckRegular(const std::string& path, const char* action) override
  {
    return IsAddress(path) ? Status::Ok() : CheckRegularFile(path, action);
  }

  Status SyncDirectory(const std::string& path) override
  {
    const int descriptor = OpenUninterrupted(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0)
    {
      return MakeSystemError(path, "open", errno);
    }
    const int failed = Synchronise(descriptor);
    const int error = errno;
    ::close(descriptor);
    return failed != 0 ? MakeSystemError(path, "write to stable storage", error) : Status::Ok();
  }

private:
  Result<std::unique_ptr<WritableFile>> OpenForWriting(
    const std::string& path, int flags, const char* action)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto file, PooledFile::Open(this->Descriptors, path, flags, action));
    return std::unique_ptr<WritableFile>(new LocalWritableFile(std::move(file)));
  }

  /// Null if the path leads to something else by now; then the next attempt may be better.
  Result<std::unique_ptr<PathLock>> TryToLock(const std::string& path, int flags)
  {
    const int descriptor = OpenUninterrupted(path, flags | O_CLOEXEC);
    if (descriptor < 0)
    {
      return MakeSystemError(path, "open", errno);
    }
    auto lock = std::make_unique<LocalPathLock>(descriptor);
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
    {
      if (errno == EWOULDBLOCK)
      {
        return Status(
          StatusCode::IoError, path + ": cannot be locked: another program is writing there");
      }
      return std::make_unique<PathLock>(); // no locks here: NFS, for one, locks no folders
    }
    // The previous holder may have removed or renamed it; then the lock is worthless.
    return lock->IsOf(path) ? std::unique_ptr<PathLock>(std::move(lock)) : nullptr;
  }

  DescriptorPool Descriptors{ DescriptorPool::ChooseLimit() };
};

std::atomic<FileSystem*> OtherFileSystem = nullptr; ///< UseFileSystem

} // namespace

thread_local const ReadingStop* ReadingStop::Current = nullptr;

std::string FindBeside(const std::string& path, const std::string& name)
{
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return IsAddress(path) ? folder.string() + "/" + name
    : IsAddress(name)    ? (folder / ".").string() + "/" + name
                         : (folder / name).string();
}

std::string HidePath(const std::string& path)
{
  return std::string(path).insert(path.rfind('/') + 1, ".");
}

FileSystem& GetLocalFileSystem()
{
  // Never destroyed: files may be open until the very end of the process.
  static LocalFileSystem& fileSystem = *new LocalFileSystem;
  FileSystem* const other = OtherFileSystem;
  return other ? *other : fileSystem;
}

void IsosurfaceUseFileSystem(FileSystem& fileSystem)
{
  OtherFileSystem = &fileSystem;
}

std::string DescribeLackOfRoom(
  FileSystem& files, const std::string& path, std::uint64_t bytes, const std::string& measure)
{
  const std::optional<std::uint64_t> room = files.FindFreeBytes(path);
  return !room || bytes <= *room
    ? std::string()
    : path + ": takes " + measure + " " + std::to_string((bytes >> 20) + 1) +
      " MiB, but its disk has room for " + std::to_string(*room >> 20) + " MiB";
}

Status CopyFile(
  FileSystem& files, const std::string& from, FileSystem& toFiles, const std::string& to)
{
  constexpr std::uint64_t copiedBytes = std::uint64_t{ 1 } << 20;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto source, files.OpenForReading(from));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto copy, toFiles.CreateForWriting(to));
  const std::uint64_t size = source->GetSize();
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t begin = 0; begin < size; begin += bytes.size())
  {
    bytes.resize(static_cast<std::size_t>(std::min(copiedBytes, size - begin)));
    ISOSURFACE_RETURN_IF_ERROR(source->Read(begin, bytes.size(), bytes.data()));
    ISOSURFACE_RETURN_IF_ERROR(copy->Append(bytes.data(), bytes.size()));
  }
  return copy->SyncAndClose();
}

} // namespace isosurface
