// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DescriptorPool_h
#define isosurface_DescriptorPool_h

#include "Ground/Base/Status.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>

namespace isosurface
{

/// An open file descriptor, closed by its last owner.
class Descriptor
{
public:
  explicit Descriptor(int number)
    : Number(number)
  {
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  int Get() const { return this->Number; }

private:
  int Number;
};

class PooledFile;

/**
 * Keeps the number of descriptors that a process has for its files within a limit, so that there
 * may be as many files as one likes. When there are too many, the one that was not used for the
 * longest time is closed; the next use of its file opens it again. A descriptor that is in use stays
 * open meanwhile. Any thread may use it.
 */
class DescriptorPool
{
public:
  explicit DescriptorPool(std::size_t limit)
    : Limit(limit)
  {
  }
  DescriptorPool(const DescriptorPool&) = delete;
  DescriptorPool& operator=(const DescriptorPool&) = delete;

  /// A quarter of what the system allows a process, since libraries want some, too; at most 1024.
  static std::size_t ChooseLimit();

  std::size_t GetOpenCount() const;

private:
  friend class PooledFile;
  /// Closes all descriptors that can be opened again, apart from that of `file`.
  void CloseOthers(const PooledFile& file);
  /// Makes the file the last to be closed, and closes others if there are too many. The caller has
  /// the mutex.
  void Add(PooledFile& file);

  std::size_t Limit;
  mutable std::mutex Mutex;
  std::list<PooledFile*> Open; ///< the one that was used last is last
};

/// A file whose descriptor may be closed and opened again between uses. Only regular files.
class PooledFile
{
public:
  /// `flags` are those of open(2). The first opening may create the file.
  static Result<std::unique_ptr<PooledFile>> Open(
    DescriptorPool& pool, const std::string& path, int flags, const char* action);
  PooledFile(const PooledFile&) = delete;
  PooledFile& operator=(const PooledFile&) = delete;
  ~PooledFile();

  const std::string& GetPath() const { return this->Path; }
  std::uint64_t GetSize() const { return this->Size; }

  /// The descriptor; an error if another file is at the path when it is opened again.
  Result<std::shared_ptr<Descriptor>> Use();
  /// The descriptor, opened anew if it still is `stale`, which the server of files has forgotten.
  Result<std::shared_ptr<Descriptor>> Renew(const std::shared_ptr<Descriptor>& stale);

private:
  friend class DescriptorPool;
  PooledFile(DescriptorPool& pool, std::string path, int flags)
    : Pool(pool)
    , Path(std::move(path))
    , Flags(flags)
  {
  }
  /// Opens the path by these flags; closes other files if there are no descriptors left.
  Result<std::shared_ptr<Descriptor>> OpenPath(int flags, const char* action);

  DescriptorPool& Pool;
  std::string Path;
  int Flags; ///< of opening again
  std::uint64_t Size = 0;
  std::uint64_t Device = 0;
  std::uint64_t Inode = 0;
  std::shared_ptr<Descriptor> Current;    ///< guarded by the pool's mutex
  std::list<PooledFile*>::iterator Place; ///< in the pool's list, if Current is there
};

/// open(2), mode 0666, again if a signal interrupts it; never with the number of a standard stream.
int OpenUninterrupted(const std::string& path, int flags);

/// An error of the system, with the path and the system's words for it.
Status MakeSystemError(const std::string& path, const char* action, int error);

/// Ok if there is a regular file at the path, or nothing: then whoever opens it neither waits (as
/// for the other end of a FIFO) nor does something to a device.
Status CheckRegularFile(const std::string& path, const char* action);

} // namespace isosurface

#endif
