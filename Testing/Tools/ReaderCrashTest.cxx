// SPDX-License-Identifier: BSD-3-Clause
#include "ReaderCrash.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <string>

using namespace isosurface;

namespace
{

const std::string Words = "scan.vti: the reader crashed";

class ReaderCrashTest : public testing::Test
{
protected:
  ReaderCrashTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(ReaderCrashTest, NamesTheFileAndEndsTheProcessAsTheSignalDoes)
{
  for (const int signal : { SIGSEGV, SIGBUS, SIGFPE, SIGILL })
  {
    EXPECT_EXIT(
      {
        const ReaderCrash crash(Words);
        std::raise(signal);
      },
      testing::KilledBySignal(signal), Words + "\n");
  }
}

TEST_F(ReaderCrashTest, NamesTheFileOfALibraryThatAborts)
{
  EXPECT_EXIT(
    {
      const ReaderCrash crash(Words);
      std::abort();
    },
    testing::KilledBySignal(SIGABRT), Words);
}

TEST_F(ReaderCrashTest, SaysNothingOfACrashBehindTheReader)
{
  EXPECT_EXIT(
    {
      {
        const ReaderCrash crash(Words);
      }
      std::raise(SIGSEGV);
    },
    testing::KilledBySignal(SIGSEGV), "^$");
}

TEST_F(ReaderCrashTest, CutsWordsThatAreTooLong)
{
  EXPECT_EXIT(
    {
      const ReaderCrash crash(Words + std::string(5000, 'x'));
      std::raise(SIGSEGV);
    },
    testing::KilledBySignal(SIGSEGV), Words + "xxx");
}

} // namespace
