// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FileSystem_h
#define isosurface_FileSystem_h

#include "Base/Status.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// A file that is read at any offset, by several threads at once.
class RandomAccessFile
{
public:
  virtual ~RandomAccessFile() = default;
  /// Reads exactly `size` bytes; fewer available is Corrupt ("truncated"), naming the file.
  virtual Status Read(std::uint64_t offset, std::size_t size, void* bytes) const = 0;
  /// Tells that these bytes will be read soon, so that a disk can begin. Does not wait for them.
  virtual void Prefetch(std::uint64_t, std::uint64_t) const {}
  virtual std::uint64_t GetSize() const = 0;
  virtual const std::string& GetPath() const = 0;
};

/// A new file that is written front to back, or in place where it was written before.
class WritableFile
{
public:
  virtual ~WritableFile() = default;
  virtual Status Append(const void* bytes, std::size_t size) = 0;
  virtual Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) = 0;
  /// Bytes appended so far.
  virtual std::uint64_t GetSize() const = 0;
  /// Flushes to stable storage, then closes; a file that is dropped without it may be incomplete.
  virtual Status SyncAndClose() = 0;
  virtual const std::string& GetPath() const = 0;
};

/// The right to change a folder; given back when it is dropped, or when the process ends, however
/// it does.
class FolderLock
{
public:
  virtual ~FolderLock() = default;
  /// Whether nobody else can have it: there are file systems that know no locks.
  virtual bool IsExclusive() const { return false; }
};

/**
 * The one door to the disk: everything in Core reads and writes through it, so that tests can put
 * a failing disk in its place. Errors name the path and the system's reason.
 */
class FileSystem
{
public:
  virtual ~FileSystem() = default;
  virtual Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) = 0;
  /// Creates the file, emptying one that is there.
  virtual Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) = 0;
  /// Opens a file that is there to write in place (WriteAt); several programs may do so at once.
  virtual Result<std::unique_ptr<WritableFile>> OpenForUpdate(const std::string& path)
  {
    return Status(StatusCode::Unsupported, path + ": cannot be written by several programs");
  }
  /// Replaces `to` in one step: whoever opens it sees the old file or the new one.
  virtual Status Rename(const std::string& from, const std::string& to) = 0;
  virtual Status MakeDirectories(const std::string& path) = 0;
  /// Makes one folder that is not there yet: of several programs that try, one succeeds.
  virtual Status MakeNewDirectory(const std::string& path) { return this->MakeDirectories(path); }
  /// Removes a file, or a folder with all that is in it; what is not there is no error.
  virtual Status RemoveAll(const std::string& path) = 0;
  virtual bool Exists(const std::string& path) = 0;
  /// The names (not paths) in a folder, sorted; a missing folder has none.
  virtual Result<std::vector<std::string>> List(const std::string& path) = 0;
  /// Makes a folder that is missing, and takes its lock. IoError if somebody else has it.
  virtual Result<std::unique_ptr<FolderLock>> LockFolder(const std::string& path)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->MakeDirectories(path));
    return std::make_unique<FolderLock>();
  }
  /// Makes the names in a folder durable.
  virtual Status SyncDirectory(const std::string& path) = 0;
};

/// The machine's own file system. Stateless; may be used from any thread.
FileSystem& GetLocalFileSystem();

} // namespace isosurface

#endif
