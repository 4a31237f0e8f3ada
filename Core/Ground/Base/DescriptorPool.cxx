// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/DescriptorPool.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

/// Why a path cannot be opened that leads to something else than a regular file; null for one.
const char* FindStrangeKind(mode_t mode)
{
  return S_ISREG(mode) ? nullptr
    : S_ISDIR(mode)    ? "Is a directory"
    : S_ISFIFO(mode)   ? "it is a FIFO, not a file"
    : S_ISSOCK(mode)   ? "it is a socket, not a file"
                       : "it is a device, not a file";
}

/// What is missing may be missing by design, what a link names may not.
bool IsLinkToNothing(const std::string& path)
{
  struct stat information = {};
  return ::stat(path.c_str(), &information) != 0 && errno == ENOENT &&
    ::lstat(path.c_str(), &information) == 0;
}

Status MakeKindError(const std::string& path, const char* action, const char* kind)
{
  return Status(StatusCode::IoError, path + ": cannot " + action + ": " + kind);
}

} // namespace

int OpenUninterrupted(const std::string& path, int flags)
{
  int number = -1;
  do
  {
    number = ::open(path.c_str(), flags, 0666);
  } while (number < 0 && errno == EINTR);
  if (number < 0 || number > STDERR_FILENO)
  {
    return number;
  }
  // Where standard input, output or error is closed, a file would get what is printed.
  const int above = ::fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int error = errno;
  ::close(number);
  errno = error;
  return above;
}

Status MakeSystemError(const std::string& path, const char* action, int error)
{
  const StatusCode code = error == ENOENT || error == ENOTDIR ? StatusCode::NotFound
    : error == ENOMEM                                         ? StatusCode::OutOfMemory
    : error == ENOSPC || error == EDQUOT || error == EFBIG    ? StatusCode::DiskFull
                                                              : StatusCode::IoError;
  return Status(code, path + ": cannot " + action + ": " + std::strerror(error));
}

Status CheckRegularFile(const std::string& path, const char* action)
{
  struct stat information = {};
  if (::stat(path.c_str(), &information) != 0)
  {
    return Status::Ok(); // the call that needs the file tells why
  }
  const char* kind = FindStrangeKind(information.st_mode);
  return kind ? MakeKindError(path, action, kind) : Status::Ok();
}

Descriptor::~Descriptor()
{
  static_cast<void>(::close(this->Number));
}

std::size_t DescriptorPool::ChooseLimit()
{
  struct rlimit limit = {};
  constexpr std::size_t most = 1024;
  constexpr std::size_t least = 16;
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
  {
    return most;
  }
  return std::clamp(static_cast<std::size_t>(limit.rlim_cur / 4), least, most);
}

std::size_t DescriptorPool::GetOpenCount() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Open.size();
}

void DescriptorPool::Add(PooledFile& file)
{
  file.Place = this->Open.insert(this->Open.end(), &file);
  while (this->Open.size() > std::max<std::size_t>(1, this->Limit))
  {
    // Who uses the descriptor has a share in it.
    this->Open.front()->Current.reset();
    this->Open.pop_front();
  }
}

void DescriptorPool::CloseOthers(const PooledFile& file)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto other = this->Open.begin(); other != this->Open.end();)
  {
    if (*other == &file)
    {
      ++other;
      continue;
    }
    (*other)->Current.reset();
    other = this->Open.erase(other);
  }
}

Result<std::unique_ptr<PooledFile>> PooledFile::Open(
  DescriptorPool& pool, const std::string& path, int flags, const char* action)
{
  ISOSURFACE_RETURN_IF_ERROR(CheckRegularFile(path, action));
  if ((flags & O_CREAT) == 0 && IsLinkToNothing(path))
  {
    return MakeKindError(path, action, "it is a link to a file that does not exist");
  }
  std::unique_ptr<PooledFile> file(new PooledFile(pool, path, flags & ~(O_CREAT | O_TRUNC)));
  ISOSURFACE_ASSIGN_OR_RETURN(auto descriptor, file->OpenPath(flags, action));
  struct stat information = {};
  if (::fstat(descriptor->Get(), &information) != 0)
  {
    return MakeSystemError(path, action, errno);
  }
  if (const char* kind = FindStrangeKind(information.st_mode))
  {
    return MakeKindError(path, action, kind);
  }
  file->Size = static_cast<std::uint64_t>(information.st_size);
  file->Device = static_cast<std::uint64_t>(information.st_dev);
  file->Inode = static_cast<std::uint64_t>(information.st_ino);
  const std::lock_guard<std::mutex> lock(pool.Mutex);
  file->Current = std::move(descriptor);
  pool.Add(*file);
  return file;
}

PooledFile::~PooledFile()
{
  const std::lock_guard<std::mutex> lock(this->Pool.Mutex);
  if (this->Current)
  {
    this->Pool.Open.erase(this->Place);
  }
}

Result<std::shared_ptr<Descriptor>> PooledFile::OpenPath(int flags, const char* action)
{
  // O_NONBLOCK: does not wait if the path has become a FIFO meanwhile.
  flags |= O_CLOEXEC | O_NONBLOCK;
  int number = OpenUninterrupted(this->Path, flags);
  if (number < 0 && (errno == EMFILE || errno == ENFILE))
  {
    this->Pool.CloseOthers(*this);
    number = OpenUninterrupted(this->Path, flags);
  }
  if (number < 0)
  {
    return errno == ELOOP && (flags & O_NOFOLLOW) != 0
      ? MakeKindError(this->Path, action, "it is a link, and nothing is written through one")
      : MakeSystemError(this->Path, action, errno);
  }
  return std::make_shared<Descriptor>(number);
}

Result<std::shared_ptr<Descriptor>> PooledFile::Renew(const std::shared_ptr<Descriptor>& stale)
{
  {
    const std::lock_guard<std::mutex> lock(this->Pool.Mutex);
    if (this->Current == stale)
    {
      this->Current.reset();
      this->Pool.Open.erase(this->Place);
    }
  }
  return this->Use();
}

Result<std::shared_ptr<Descriptor>> PooledFile::Use()
{
  {
    const std::lock_guard<std::mutex> lock(this->Pool.Mutex);
    if (this->Current)
    {
      this->Pool.Open.splice(this->Pool.Open.end(), this->Pool.Open, this->Place);
      return this->Current;
    }
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto descriptor, this->OpenPath(this->Flags, "open again"));
  struct stat information = {};
  if (::fstat(descriptor->Get(), &information) != 0)
  {
    return MakeSystemError(this->Path, "open again", errno);
  }
  if (static_cast<std::uint64_t>(information.st_dev) != this->Device ||
    static_cast<std::uint64_t>(information.st_ino) != this->Inode)
  {
    return Status(StatusCode::NotFound, this->Path + ": was replaced since it was opened");
  }
  const std::lock_guard<std::mutex> lock(this->Pool.Mutex);
  if (!this->Current)
  {
    this->Current = std::move(descriptor);
    this->Pool.Add(*this);
  }
  return this->Current;
}

} // namespace isosurface
