// SPDX-License-Identifier: BSD-3-Clause
// Defines the system's calls anew: the symbols of a program come before those of its libraries.
#include "DiskFaults.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

using Kind = DiskFaults::Kind;

/// What a call can be told to do.
enum class Deed
{
  Work,
  Fail,
  Half,
  HalfThenEnd,
  Flip
};

std::string Folder;
std::atomic<Kind> Armed{ Kind::None };
std::atomic<int> Error{ 0 };
std::atomic<std::uint64_t> Target{ 0 };
std::atomic<std::uint64_t> Count{ 0 };
std::atomic<bool> Happened{ false };
std::array<std::atomic<bool>, 65536> IsWatched;
std::array<std::atomic<bool>, 65536> IsStale;

bool IsBelow(const char* path)
{
  return !Folder.empty() && std::string(path).compare(0, Folder.size(), Folder) == 0;
}

bool IsWatchedDescriptor(int descriptor)
{
  return descriptor >= 0 && static_cast<std::size_t>(descriptor) < IsWatched.size() &&
    IsWatched[static_cast<std::size_t>(descriptor)];
}

enum class Call
{
  Open,
  Create,
  Read,
  Write,
  Sync,
  Name ///< rename, mkdir
};

constexpr int EndOfKilled = 99;

/// Whether a call can have the armed fault at all.
bool IsPossible(Call call)
{
  switch (Armed)
  {
    case Kind::Fail:
    case Kind::FailFromNow:
      return Error == EMFILE                ? call == Call::Open || call == Call::Create
        : Error == ENOSPC || Error == EROFS ? call != Call::Open && call != Call::Read
                                            : true;
    case Kind::Interrupt:
      return call != Call::Name;
    case Kind::Short:
      return call == Call::Read || call == Call::Write;
    case Kind::Stale:
    case Kind::Flip:
      return call == Call::Read;
    case Kind::NoLocks:
      return false;
    default:
      return Armed != Kind::None;
  }
}

Deed Ask(Call call)
{
  const std::uint64_t number = Count++;
  const bool isItsTurn = number == Target || (Armed == Kind::FailFromNow && number > Target);
  if (!isItsTurn || !IsPossible(call))
  {
    return Deed::Work;
  }
  Happened = true;
  switch (Armed)
  {
    case Kind::Short:
      return Deed::Half;
    case Kind::Flip:
      return Deed::Flip;
    case Kind::Kill:
      ::_exit(EndOfKilled);
    case Kind::Tear:
      if (call != Call::Write)
      {
        ::_exit(EndOfKilled);
      }
      return Deed::HalfThenEnd;
    default:
      errno = Armed == Kind::Interrupt ? EINTR : Armed == Kind::Stale ? ESTALE : Error.load();
      return Deed::Fail;
  }
}

template <typename Function>
Function* FindNext(const char* name)
{
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int OpenWatched(const char* path, int flags, mode_t mode)
{
  static auto* const next = FindNext<int(const char*, int, ...)>("open");
  const bool isBelow = IsBelow(path);
  if (isBelow && Ask((flags & O_CREAT) != 0 ? Call::Create : Call::Open) == Deed::Fail)
  {
    return -1;
  }
  const int descriptor = next(path, flags, mode);
  if (descriptor >= 0 && static_cast<std::size_t>(descriptor) < IsWatched.size())
  {
    IsWatched[static_cast<std::size_t>(descriptor)] = isBelow;
    IsStale[static_cast<std::size_t>(descriptor)] = false;
  }
  return descriptor;
}

/// The number of bytes that a call is to move; -1 if it fails.
ssize_t FindBytes(Deed deed, std::size_t size)
{
  return deed == Deed::Fail                                ? -1
    : deed == Deed::Work || deed == Deed::Flip || size < 2 ? static_cast<ssize_t>(size)
                                                           : static_cast<ssize_t>(size / 2);
}

ssize_t ReadWatched(int descriptor, void* bytes, std::size_t size, off_t offset)
{
  static auto* const next = FindNext<ssize_t(int, void*, std::size_t, off_t)>("pread");
  const bool isWatched = IsWatchedDescriptor(descriptor);
  if (isWatched && IsStale[static_cast<std::size_t>(descriptor)])
  {
    errno = ESTALE;
    return -1;
  }
  const Deed deed = isWatched ? Ask(Call::Read) : Deed::Work;
  const ssize_t wanted = FindBytes(deed, size);
  if (wanted < 0)
  {
    IsStale[static_cast<std::size_t>(descriptor)] = Armed == Kind::Stale;
    return -1;
  }
  const ssize_t done = next(descriptor, bytes, static_cast<std::size_t>(wanted), offset);
  if (deed == Deed::Flip && done > 0)
  {
    static_cast<unsigned char*>(bytes)[done / 2] ^= 0x10;
  }
  return done;
}

ssize_t WriteWatched(int descriptor, const void* bytes, std::size_t size, off_t offset)
{
  static auto* const next = FindNext<ssize_t(int, const void*, std::size_t, off_t)>("pwrite");
  const Deed deed = IsWatchedDescriptor(descriptor) ? Ask(Call::Write) : Deed::Work;
  const ssize_t wanted = FindBytes(deed, size);
  const ssize_t done =
    wanted < 0 ? -1 : next(descriptor, bytes, static_cast<std::size_t>(wanted), offset);
  if (deed == Deed::HalfThenEnd)
  {
    ::_exit(EndOfKilled);
  }
  return done;
}

} // namespace

void DiskFaults::Watch(const std::string& folder)
{
  Folder = folder;
}

void DiskFaults::Arm(Kind kind, int error, std::uint64_t operation)
{
  Armed = Kind::None;
  Error = error;
  Target = operation;
  Count = 0;
  Happened = false;
  Armed = kind;
}

std::uint64_t DiskFaults::GetOperations()
{
  return Count;
}

bool DiskFaults::HasHappened()
{
  return Happened;
}

} // namespace isosurface

extern "C"
{
  int open(const char* path, int flags, ...)
  {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return isosurface::OpenWatched(path, flags, mode);
  }
  ssize_t pread(int descriptor, void* bytes, size_t size, off_t offset)
  {
    return isosurface::ReadWatched(descriptor, bytes, size, offset);
  }
  ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset)
  {
    return isosurface::WriteWatched(descriptor, bytes, size, offset);
  }
  int fsync(int descriptor)
  {
    // No power is lost here, so nothing has to wait for the disk.
    return isosurface::IsWatchedDescriptor(descriptor) &&
        isosurface::Ask(isosurface::Call::Sync) == isosurface::Deed::Fail
      ? -1
      : 0;
  }
// There is a struct of this name, too.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
  int flock(int descriptor, int operation)
  {
    static auto* const next = isosurface::FindNext<int(int, int)>("flock");
    if (isosurface::IsWatchedDescriptor(descriptor) &&
      isosurface::Armed == isosurface::Kind::NoLocks)
    {
      isosurface::Happened = true;
      errno = ENOLCK;
      return -1;
    }
    return next(descriptor, operation);
  }
#pragma GCC diagnostic pop
  int rename(const char* from, const char* to)
  {
    static auto* const next = isosurface::FindNext<int(const char*, const char*)>("rename");
    return isosurface::IsBelow(to) &&
        isosurface::Ask(isosurface::Call::Name) == isosurface::Deed::Fail
      ? -1
      : next(from, to);
  }
  int mkdir(const char* path, mode_t mode)
  {
    static auto* const next = isosurface::FindNext<int(const char*, mode_t)>("mkdir");
    return isosurface::IsBelow(path) &&
        isosurface::Ask(isosurface::Call::Name) == isosurface::Deed::Fail
      ? -1
      : next(path, mode);
  }
}
