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
    std::filesystem::create_directories(this->Place);
    this->Limits.MemoryBytes = 512 * Mebibyte;
    this->Limits.FileBytes = Mebibyte;
    this->Limits.Seconds = 60;
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

TEST_F(SandboxTest, RefusesFilesBeyondTheLimit)
{
  const auto work = [&]
  {
    const int file = ::open((this->Place + "/file").c_str(), O_CREAT | O_WRONLY, 0666);
    const bool fits = ::pwrite(file, "x", 1, static_cast<::off_t>(Mebibyte) - 1) == 1;
    const bool isTooLarge =
      ::pwrite(file, "x", 1, static_cast<::off_t>(Mebibyte)) == -1 && errno == EFBIG;
    return fits && isTooLarge ? 0 : 1;
  };
  EXPECT_EQ(this->Run(work), 0) << this->Message;
}

} // namespace
