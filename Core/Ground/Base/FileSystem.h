// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FileSystem_h
#define isosurface_FileSystem_h

#include "Ground/Base/Status.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// A file that several threads may read at once, at any offset.
class RandomAccessFile
{
public:
  virtual ~RandomAccessFile() = default;
  /// Reads exactly `size` bytes; fewer available is Corrupt ("truncated"), naming the file.
  virtual Status Read(std::uint64_t offset, std::size_t size, void* bytes) const = 0;
  /// Hints that these bytes will be read soon. Does not wait for them.
  virtual void Prefetch(std::uint64_t, std::uint64_t) const {}
  virtual std::uint64_t GetSize() const = 0;
  virtual const std::string& GetPath() const = 0;
};

/// A file for writing: at its end, or over bytes that were written before.
class WritableFile
{
public:
  virtual ~WritableFile() = default;
  virtual Status Append(const void* bytes, std::size_t size) = 0;
  virtual Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) = 0;
  /// The number of bytes appended so far.
  virtual std::uint64_t GetSize() const = 0;
  /// Flushes to stable storage.
  virtual Status Sync() = 0;
  /// Flushes to stable storage, then closes. Without this call the file may be incomplete.
  virtual Status SyncAndClose() = 0;
  virtual const std::string& GetPath() const = 0;
};

/// The lock of a folder or file. Released by the destructor, and by the system when the process ends
/// or crashes.
class PathLock
{
public:
  virtual ~PathLock() = default;
  /// Whether no other program can hold it. False on file systems without locks.
  virtual bool IsExclusive() const { return false; }
};

/// Whether a path is the address of an object on the web: http://, https:// or s3://.
bool IsAddress(const std::string& path);
/// So many threads, or more if the path is an address, where each waits for a server most of the time.
int ChooseReadingThreads(const std::string& path, int threads);

/// What tells whether files were changed, without reading them.
struct FileState
{
  std::uint64_t Files = 0;
  std::uint64_t Bytes = 0;   ///< of all of them
  std::int64_t Modified = 0; ///< the last of their times of modification, in ns since 1970

  bool operator==(const FileState& other) const
  {
    return this->Files == other.Files && this->Bytes == other.Bytes &&
      this->Modified == other.Modified;
  }
};

/**
 * All I/O of Core goes through it, so that tests can replace it by a disk that fails. Errors name path
 * and reason. A link, perhaps a stranger's, is never written through: a created file replaces it.
 */
class FileSystem
{
public:
  virtual ~FileSystem() = default;
  virtual Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) = 0;
  /// The same of a file of which the first bytes are read first, or, if negative, the last ones: an
  /// address is asked for them at once, and for exactly what else is read.
  virtual Result<std::unique_ptr<RandomAccessFile>> OpenPart(
    const std::string& path, std::int64_t /*bytes*/)
  {
    return this->OpenForReading(path);
  }
  /// Hints that these files, of which some may not exist, will be opened soon: addresses are asked for
  /// all of them at once.
  virtual void LookFor(const std::vector<std::string>&) {}
  /// Creates the file. An existing one is emptied.
  virtual Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) = 0;
  /// Opens an existing file for WriteAt(). Several programs may do so at once.
  virtual Result<std::unique_ptr<WritableFile>> OpenForUpdate(const std::string& path)
  {
    return Status(StatusCode::Unsupported, path + ": cannot be written by several programs");
  }
  /// Opens an existing file to append to it. Bytes beyond `size` are cut off; Corrupt
  /// ("truncated") if the file has fewer.
  virtual Result<std::unique_ptr<WritableFile>> OpenForAppending(
    const std::string& path, std::uint64_t)
  {
    return Status(StatusCode::Unsupported, path + ": cannot be appended to");
  }
  /// Replaces `to` atomically: a program that opens it gets the old file or the new one.
  virtual Status Rename(const std::string& from, const std::string& to) = 0;
  virtual Status MakeDirectories(const std::string& path) = 0;
  /// Creates a folder that does not exist yet. If several programs try, one succeeds.
  virtual Status MakeNewDirectory(const std::string& path) { return this->MakeDirectories(path); }
  /// Removes a file, or a folder with its contents. Ok if it does not exist.
  virtual Status RemoveAll(const std::string& path) = 0;
  virtual bool Exists(const std::string& path) = 0;
  /// The names (not paths) in a folder, sorted; none if the folder does not exist.
  virtual Result<std::vector<std::string>> List(const std::string& path) = 0;
  /// Creates the folder if necessary and locks it. IoError for a link, or if another program has it.
  virtual Result<std::unique_ptr<PathLock>> LockFolder(const std::string& path)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->MakeDirectories(path));
    return std::make_unique<PathLock>();
  }
  /// The same of a file, which is created if it does not exist; its contents stay. A locked file may
  /// be written, removed or renamed by the holder; another program then locks a new one.
  virtual Result<std::unique_ptr<PathLock>> LockFile(const std::string&)
  {
    return std::make_unique<PathLock>();
  }
  /// The state of a file, or of all files in a folder and the folders in it. Cost: a look at each.
  virtual Result<FileState> FindState(const std::string& path)
  {
    return Status(StatusCode::Unsupported, path + ": has no state");
  }
  /// The bytes that files at the path, which need not exist, can have on their disk. Nothing where
  /// that is not known.
  virtual std::optional<std::uint64_t> FindFreeBytes(const std::string& /*path*/) { return {}; }
  /// Ok if there is nothing at the path, or a regular file: a FIFO or a device is neither read nor
  /// replaced. `action` is what cannot be done with it, for the message.
  virtual Status CheckRegular(const std::string&, const char* /*action*/) { return Status::Ok(); }
  /// Flushes the names in a folder to stable storage.
  virtual Status SyncDirectory(const std::string& path) = 0;
};

/// A file that another one names, seen from the folder of that one. A file at an address names others of its
/// server alone, and a local file no address.
std::string FindBeside(const std::string& path, const std::string& name);

/// The path with a dot before its name, which file dialogs and `ls` hide.
std::string HidePath(const std::string& path);

/// The local file system, and objects on the web by their addresses (RemoteFileSystem); any thread may use it. All files of the process share a limited number of
/// descriptors (DescriptorPool). What is no regular file is refused at once, without waiting.
FileSystem& GetLocalFileSystem();

/// A warning if the disk of `path` has no room for `bytes`, which are `measure` ("about") the bytes
/// to be written; empty if it has room, or that is not known.
std::string DescribeLackOfRoom(FileSystem& files, const std::string& path, std::uint64_t bytes,
  const std::string& measure = "up to");

/// Copies a file from one file system to another, or within one, and brings it to stable storage.
Status CopyFile(
  FileSystem& files, const std::string& from, FileSystem& toFiles, const std::string& to);

} // namespace isosurface

#endif
