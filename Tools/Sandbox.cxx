// SPDX-License-Identifier: BSD-3-Clause
#include "Sandbox.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
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

// --- System calls ---------------------------------------------------------------------------------

#if defined(__x86_64__)
constexpr std::uint32_t Processor = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t Processor = AUDIT_ARCH_AARCH64;
#elif defined(__riscv) && __riscv_xlen == 64
constexpr std::uint32_t Processor = AUDIT_ARCH_RISCV64;
#elif defined(__powerpc64__) && defined(__LITTLE_ENDIAN__)
constexpr std::uint32_t Processor = AUDIT_ARCH_PPC64LE;
#else
constexpr std::uint32_t Processor = 0;
#endif

/// What no library needs to decode a file.
constexpr int RefusedCalls[] = {
  // The network; io_uring reaches it past this filter.
  SYS_socket, SYS_socketpair, SYS_io_uring_setup,
  // Programs and other processes.
  SYS_execve, SYS_execveat, SYS_ptrace, SYS_process_vm_readv, SYS_process_vm_writev, SYS_pidfd_open,
  SYS_pidfd_getfd, SYS_pidfd_send_signal, SYS_tkill, SYS_rt_sigqueueinfo, SYS_rt_tgsigqueueinfo,
#ifdef SYS_fork
  SYS_fork, SYS_vfork,
#endif
  // The kernel, and what it keeps for all.
  SYS_add_key, SYS_keyctl, SYS_request_key, SYS_bpf, SYS_perf_event_open, SYS_userfaultfd,
  SYS_mount, SYS_umount2, SYS_pivot_root, SYS_chroot, SYS_unshare, SYS_setns, SYS_open_by_handle_at,
  SYS_personality, SYS_init_module, SYS_finit_module, SYS_kexec_load, SYS_reboot
};

constexpr std::uint32_t FindArgument(std::size_t number)
{
  // The lower half, on the processors above.
  return static_cast<std::uint32_t>(offsetof(seccomp_data, args) + 8 * number);
}

/// A program of the kernel that lets calls fail which the sandbox refuses.
class CallFilter
{
public:
  CallFilter()
  {
    this->Load(offsetof(seccomp_data, arch));
    this->RefuseUnless(BPF_JEQ, Processor);
    this->Load(offsetof(seccomp_data, nr));
#ifdef __x86_64__
    // The same calls with other numbers, of x32.
    this->RefuseIf(BPF_JGE, 0x40000000);
#endif
    for (const int call : RefusedCalls)
    {
      this->RefuseIf(BPF_JEQ, static_cast<std::uint32_t>(call));
    }
    // Threads are made by clone, whose flags can be seen, if there is no clone3.
    this->Add(BPF_JMP | BPF_JEQ | BPF_K, SYS_clone3, 0, 1);
    this->Add(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS);
    this->OfCall(SYS_clone, 0, BPF_JSET, CLONE_THREAD, false);
    const auto self = static_cast<std::uint32_t>(::getpid());
    this->OfCall(SYS_kill, 0, BPF_JEQ, self, false);
    this->OfCall(SYS_tgkill, 0, BPF_JEQ, self, false);
    this->OfCall(SYS_prlimit64, 0, BPF_JEQ, 0, false);
    // Types text into the terminal.
    this->OfCall(SYS_ioctl, 1, BPF_JEQ, TIOCSTI, true);
    this->Add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  }

  Status Install()
  {
    const sock_fprog program = { static_cast<unsigned short>(this->Steps.size()),
      this->Steps.data() };
    return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0 ? Status::Ok()
                                                                       : MakeSystemError("seccomp");
  }

private:
  void Add(int code, std::uint32_t operand, std::uint8_t ifTrue = 0, std::uint8_t ifFalse = 0)
  {
    this->Steps.push_back({ static_cast<std::uint16_t>(code), ifTrue, ifFalse, operand });
  }
  void Load(std::size_t place)
  {
    this->Add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(place));
  }
  void Refuse()
  {
    this->Add(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
  }
  void RefuseIf(int test, std::uint32_t operand)
  {
    this->Add(BPF_JMP | test | BPF_K, operand, 0, 1);
    this->Refuse();
  }
  void RefuseUnless(int test, std::uint32_t operand)
  {
    this->Add(BPF_JMP | test | BPF_K, operand, 1, 0);
    this->Refuse();
  }
  /// A call that is refused if a test of its argument has this result.
  void OfCall(
    std::uint32_t call, std::size_t argument, int test, std::uint32_t operand, bool isRefused)
  {
    this->Add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4);
    this->Load(FindArgument(argument));
    if (isRefused)
    {
      this->RefuseIf(test, operand);
    }
    else
    {
      this->RefuseUnless(test, operand);
    }
    this->Add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  }

  std::vector<sock_filter> Steps;
};

// --- Files ----------------------------------------------------------------------------------------

/// From now on this process makes, changes and removes files in the folder alone. A kernel without
/// Landlock leaves it all the rights of its user.
Status WriteOnlyWithin(const std::string& folder)
{
  const long version =
    ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1)
  {
    return Status::Ok();
  }
  // The headers of Debian 12 do not name the last one.
  constexpr std::uint64_t refer = LANDLOCK_ACCESS_FS_REFER;
  constexpr std::uint64_t truncate = std::uint64_t{ 1 } << 14;
  const std::uint64_t own = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
    LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
    (version >= 2 ? refer : 0) | (version >= 3 ? truncate : 0);
  landlock_ruleset_attr handled = {};
  handled.handled_access_fs = own | LANDLOCK_ACCESS_FS_MAKE_CHAR | LANDLOCK_ACCESS_FS_MAKE_BLOCK |
    LANDLOCK_ACCESS_FS_MAKE_FIFO | LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;
  const auto rules =
    static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, sizeof(handled), 0));
  bool isDone = rules >= 0;
  if (isDone && !folder.empty())
  {
    landlock_path_beneath_attr rule = {};
    rule.allowed_access = own;
    rule.parent_fd = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    isDone = rule.parent_fd >= 0 &&
      ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0;
  }
  isDone = isDone && ::syscall(SYS_landlock_restrict_self, rules, 0) == 0;
  return isDone ? Status::Ok() : MakeSystemError("Landlock");
}

// --- Limits ---------------------------------------------------------------------------------------

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
  ISOSURFACE_RETURN_IF_ERROR(RenewTime(limits.Seconds));
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
  {
    return MakeSystemError("no new privileges");
  }
  if (Processor == 0)
  {
    errno = ENOSYS;
    return MakeSystemError("a filter of system calls for this processor");
  }
  ISOSURFACE_RETURN_IF_ERROR(WriteOnlyWithin(limits.Folder));
  return CallFilter().Install();
}

// --- The two processes ----------------------------------------------------------------------------

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
