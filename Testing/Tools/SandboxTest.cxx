// SPDX-License-Identifier: BSD-3-Clause
#include "Sandbox.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/ioctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

constexpr std::uint64_t Mebibyte = std::uint64_t{ 1 } << 20;

class SandboxTest : public testing::Test
{
protected:
  SandboxTest()
  {
    std::filesystem::remove_all(this->Place);
    std::filesystem::create_directories(this->Place + "/inside");
    this->Limits.MemoryBytes = 512 * Mebibyte;
    this->Limits.FileBytes = Mebibyte;
    this->Limits.Seconds = 60;
    this->Limits.Folder = this->Place + "/inside";
  }
  ~SandboxTest() override { std::filesystem::remove_all(this->Place); }

  /// What the work returns, or -1 with the message in Message.
  int Run(const std::function<int()>& work)
  {
    const auto ended = RunInSandbox(this->Limits,
      [&](const Status& limited) { return limited.IsOk() && IsInSandbox() ? work() : 99; });
    this->Message = ended.IsOk() ? "" : ended.GetStatus().GetMessage();
    return ended.IsOk() ? *ended : -1;
  }

  SandboxLimits Limits;
  std::string Message;
  const std::string Place =
    (std::filesystem::temp_directory_path() / ("sandbox-" + std::to_string(::getpid()))).string();
};

/// Uses so much processor time, and tells of growing progress if there is one.
void Burn(double seconds, const Progress& progress = {})
{
  const std::clock_t begin = std::clock();
  double burnt = 0;
  while (burnt < seconds)
  {
    burnt = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (progress)
    {
      progress(burnt / seconds);
    }
  }
}

/// Whether a call failed for want of permission.
bool IsRefused(long result)
{
  return result == -1 && errno == EPERM;
}

bool HasLandlock()
{
  return ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) > 0;
}

TEST_F(SandboxTest, ReturnsWhatTheWorkReturns)
{
  EXPECT_FALSE(IsInSandbox());
  EXPECT_EQ(this->Run([] { return 0; }), 0);
  EXPECT_EQ(this->Run([] { return 7; }), 7);
  EXPECT_FALSE(IsInSandbox());
}

TEST_F(SandboxTest, TellsHowTheWorkEndedWithoutItsResult)
{
  EXPECT_EQ(this->Run([] { return std::raise(SIGSEGV); }), -1);
  EXPECT_NE(this->Message.find("crashed (Segmentation fault)"), std::string::npos);
  EXPECT_EQ(this->Run([]() -> int { std::abort(); }), -1);
  EXPECT_NE(this->Message.find("crashed (Aborted)"), std::string::npos);
  EXPECT_EQ(this->Run([] { return ::kill(::getpid(), SIGKILL); }), -1);
  EXPECT_NE(this->Message.find("was killed"), std::string::npos);
  EXPECT_EQ(this->Run([]() -> int { std::exit(0); }), -1);
  EXPECT_NE(this->Message.find("ended the process"), std::string::npos);
  EXPECT_EQ(this->Run([]() -> int { ::_exit(0); }), -1);
  EXPECT_NE(this->Message.find("ended the process"), std::string::npos);
}

TEST_F(SandboxTest, EndsWhatTakesTimeAndDoesNotComeForward)
{
  this->Limits.Seconds = 1;
  EXPECT_EQ(this->Run(
              []
              {
                Burn(60);
                return 0;
              }),
    -1);
  EXPECT_EQ(
    this->Message, "took 1 s of processor time without progress; --sandbox-seconds allows more");
  EXPECT_EQ(this->Run(
              []
              {
                const Progress same = [](double) { return true; };
                const Progress renewing = RenewTimeWith(same);
                Burn(60, [&](double) { return renewing(0.5); });
                return 0;
              }),
    -1);
  EXPECT_EQ(this->Run(
              []
              {
                // The limit counts whole ticks, by a third more than clock() on a busy virtual machine.
                const Progress none;
                Burn(2.1, RenewTimeWith(none));
                return 0;
              }),
    0)
    << this->Message;
}

TEST_F(SandboxTest, RefusesMemoryBeyondTheLimit)
{
  EXPECT_EQ(this->Run(
              []
              {
                // Else a compiler may leave out both, as if there were memory.
                void* volatile less = std::malloc(400 * Mebibyte);
                void* volatile more = std::malloc(200 * Mebibyte);
                const int found = (less ? 1 : 0) + (more ? 2 : 0);
                std::free(less);
                return found;
              }),
    1);
}

TEST_F(SandboxTest, ReachesNoNetworkNoProgramAndNoOtherProcess)
{
  const ::pid_t waiting = ::getpid();
  const auto refused = [waiting]
  {
    const auto count = [](bool is) { return is ? 1 : 0; };
    char text[] = "x";
    char path[] = "/bin/true";
    char* arguments[] = { path, nullptr };
    rlimit limit = {};
    return count(IsRefused(::socket(AF_INET, SOCK_STREAM, 0))) +
      count(IsRefused(::socket(AF_UNIX, SOCK_STREAM, 0))) +
      count(IsRefused(::execv(path, arguments))) + count(IsRefused(::fork())) +
      count(IsRefused(::kill(waiting, 0))) +
      count(IsRefused(::ptrace(PTRACE_ATTACH, waiting, nullptr, nullptr))) +
      count(IsRefused(::prlimit(waiting, RLIMIT_CPU, nullptr, &limit))) +
      count(IsRefused(::ioctl(STDIN_FILENO, TIOCSTI, text))) +
      count(IsRefused(::syscall(SYS_io_uring_setup, 1, nullptr)));
  };
  EXPECT_EQ(this->Run(refused), 9) << this->Message;
}

TEST_F(SandboxTest, HasThreadsAndSignalsItself)
{
  const auto work = []
  {
    std::atomic<int> done{ 0 };
    std::thread first([&] { ++done; });
    std::thread second([&] { ++done; });
    first.join();
    second.join();
    return done + (::kill(::getpid(), 0) == 0 ? 1 : 0);
  };
  EXPECT_EQ(this->Run(work), 3) << this->Message;
}

TEST_F(SandboxTest, WritesWithinItsFolderAlone)
{
  if (!HasLandlock())
  {
    GTEST_SKIP() << "this kernel has no Landlock";
  }
  const std::string there = this->Place + "/there";
  ::close(::open(there.c_str(), O_CREAT | O_WRONLY, 0666));
  const auto work = [&]
  {
    const auto opens = [](const std::string& path, int flags)
    {
      const int file = ::open(path.c_str(), flags, 0666);
      ::close(file);
      return file >= 0 ? 1 : 0;
    };
    const std::string inside = this->Limits.Folder;
    const int wrong = opens(this->Place + "/new", O_CREAT | O_WRONLY) + opens(there, O_WRONLY) +
      (::unlink(there.c_str()) == 0 ? 1 : 0) +
      (::rename(there.c_str(), (inside + "/moved").c_str()) == 0 ? 1 : 0);
    const bool isRight = opens(there, O_RDONLY) == 1 &&
      opens(inside + "/new", O_CREAT | O_WRONLY | O_TRUNC) == 1 &&
      ::mkdir((inside + "/folder").c_str(), 0777) == 0 &&
      ::rename((inside + "/new").c_str(), (inside + "/folder/new").c_str()) == 0 &&
      ::unlink((inside + "/folder/new").c_str()) == 0;
    return wrong + (isRight ? 0 : 10);
  };
  EXPECT_EQ(this->Run(work), 0) << this->Message;
  this->Limits.Folder.clear();
  EXPECT_EQ(this->Run(
              [&]
              {
                const std::string path = this->Place + "/inside/other";
                return ::open(path.c_str(), O_CREAT | O_WRONLY, 0666) < 0 ? 0 : 1;
              }),
    0);
}

TEST_F(SandboxTest, RefusesFilesBeyondTheLimit)
{
  const auto work = [&]
  {
    const int file = ::open((this->Limits.Folder + "/file").c_str(), O_CREAT | O_WRONLY, 0666);
    const bool fits = ::pwrite(file, "x", 1, static_cast<::off_t>(Mebibyte) - 1) == 1;
    const bool isTooLarge =
      ::pwrite(file, "x", 1, static_cast<::off_t>(Mebibyte)) == -1 && errno == EFBIG;
    return fits && isTooLarge ? 0 : 1;
  };
  EXPECT_EQ(this->Run(work), 0) << this->Message;
}

} // namespace
