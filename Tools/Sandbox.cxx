// SPDX-License-Identifier: BSD-3-Clause
#include "Sandbox.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

std::uint64_t SecondsOfProgress = 0; // of the sandbox that this process is; 0: it is none
volatile std::sig_atomic_t WorkingProcess = 0;

Status MakeSystemError(const char* what)
{
  return Status(StatusCode::Unsupported,
    std::string("this system offers no sandbox: ") + what + ": " + std::strerror(errno));
}

Status SetLimit(int resource, std::uint64_t value, const char* name)
{
  rlimit limit = {};
  ::getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  // Time is renewed; what else is given away does not come back.
  limit.rlim_max = resource == RLIMIT_CPU ? limit.rlim_max : limit.rlim_cur;
  return ::setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) == 0
    ? Status::Ok()
    : MakeSystemError(name);
}

Status RenewTime(std::uint64_t seconds)
{
  rusage used = {};
  ::getrusage(RUSAGE_SELF, &used);
  const auto now = static_cast<std::uint64_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  return SetLimit(RLIMIT_CPU, now + 1 + seconds, "processor time");
}

std::uint64_t FindAddressSpace()
{
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

Status TakeLimits(const SandboxLimits& limits)
{
  // A crash leaves no file; a file that is too large is an error of writing it.
  ISOSURFACE_RETURN_IF_ERROR(SetLimit(RLIMIT_CORE, 0, "core files"));
  std::signal(SIGXFSZ, SIG_IGN);
  ISOSURFACE_RETURN_IF_ERROR(SetLimit(RLIMIT_FSIZE, limits.FileBytes, "file size"));
  ISOSURFACE_RETURN_IF_ERROR(
    SetLimit(RLIMIT_AS, FindAddressSpace() + limits.MemoryBytes, "address space"));
  return RenewTime(limits.Seconds);
}

[[noreturn]] void Work(const SandboxLimits& limits, const std::function<int(const Status&)>& work,
  ::pid_t parent, volatile bool* isDone)
{
  static_cast<void>(::prctl(PR_SET_PDEATHSIG, SIGKILL));
  if (::getppid() != parent)
  {
    ::_exit(1); // it has ended before; nobody waits
  }
  for (const int signal : { SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT })
  {
    std::signal(signal, SIG_DFL); // libraries of MPI print twenty lines of a crash
  }
  const Status limited = TakeLimits(limits);
  SecondsOfProgress = limits.Seconds;
  static_cast<void>(
    std::atexit([] { ::_exit(1); })); // what this process has of the other one stays
  const int code = work(limited);
  std::fflush(nullptr);
  *isDone = true;
  ::_exit(code);
}

void PassOn(int)
{
  if (WorkingProcess != 0)
  {
    ::kill(WorkingProcess, SIGTERM);
  }
}

Result<int> Explain(int ended, bool isDone, const SandboxLimits& limits)
{
  if (WIFEXITED(ended))
  {
    if (!isDone) // whatever the status says
    {
      return Status(StatusCode::Corrupt, "a library that read it ended the process");
    }
    return WEXITSTATUS(ended);
  }
  const int signal = WTERMSIG(ended);
  switch (signal)
  {
    case SIGXCPU:
      return Status(StatusCode::IoError,
        "took " + std::to_string(limits.Seconds) +
          " s of processor time without progress; --sandbox-seconds allows more");
    case SIGKILL:
      return Status(StatusCode::OutOfMemory,
        "the process that read it was killed, as by a system that has no memory left");
    case SIGINT:
    case SIGTERM:
      return Status(StatusCode::Aborted, "stopped at once");
    default:
      return Status(StatusCode::Corrupt,
        "the process that read it crashed (" + std::string(::strsignal(signal)) +
          "): the file is damaged, or a library that reads it has a fault");
  }
}

} // namespace

Result<int> RunInSandbox(
  const SandboxLimits& limits, const std::function<int(const Status& limited)>& work)
{
  // A stop that comes before the handlers are there waits for them.
  sigset_t stops;
  sigset_t before;
  sigemptyset(&stops);
  sigaddset(&stops, SIGINT);
  sigaddset(&stops, SIGTERM);
  ::sigprocmask(SIG_BLOCK, &stops, &before);
  std::fflush(nullptr);
  // Shared with the other process, which sets it when the work has returned.
  void* const page =
    ::mmap(nullptr, sizeof(bool), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  const ::pid_t parent = ::getpid();
  const ::pid_t child = page == MAP_FAILED ? -1 : ::fork();
  if (child == 0)
  {
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    Work(limits, work, parent, static_cast<volatile bool*>(page));
  }
  WorkingProcess = std::max<::pid_t>(child, 0);
  struct sigaction passing = {};
  struct sigaction interrupting = {};
  struct sigaction terminating = {};
  passing.sa_handler = PassOn;
  ::sigaction(SIGINT, &passing, &interrupting);
  ::sigaction(SIGTERM, &passing, &terminating);
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  if (child < 0)
  {
    return MakeSystemError("a process");
  }
  int ended = 0;
  while (::waitpid(child, &ended, 0) < 0 && errno == EINTR)
  {
  }
  WorkingProcess = 0;
  ::sigaction(SIGINT, &interrupting, nullptr);
  ::sigaction(SIGTERM, &terminating, nullptr);
  const bool isDone = *static_cast<volatile bool*>(page);
  ::munmap(page, sizeof(bool));
  return Explain(ended, isDone, limits);
}

bool IsInSandbox()
{
  return SecondsOfProgress != 0;
}

Progress RenewTimeWith(const Progress& progress)
{
  if (!IsInSandbox())
  {
    return progress;
  }
  return [&progress, last = 0.0](double fraction) mutable
  {
    if (fraction > last)
    {
      last = fraction;
      static_cast<void>(RenewTime(SecondsOfProgress));
    }
    return !progress || progress(fraction);
  };
}

} // namespace isosurface
