// SPDX-License-Identifier: BSD-3-Clause
#include "StopSignal.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace isosurface
{

void OpenStandardStreams()
{
  // The lowest free number is taken.
  int number = 0;
  do
  {
    number = ::open("/dev/null", O_RDWR);
  } while (number >= 0 && number <= STDERR_FILENO);
  if (number >= 0)
  {
    ::close(number);
  }
}

Status FlushStandardOutput()
{
  const std::string reason =
    std::fflush(stdout) != 0 ? std::strerror(errno) : "a part of it was lost";
  return std::ferror(stdout) != 0
    ? Status(StatusCode::IoError, "cannot write to standard output: " + reason)
    : Status::Ok();
}

namespace
{

constexpr unsigned PatienceSeconds = 1;

volatile std::sig_atomic_t StopAsked = 0;
const char* ToolName = "";

void TakeStopSignal(int)
{
  StopAsked = 1;
  ::alarm(PatienceSeconds);
}

/// Nobody has asked whether to stop: the process is within a library, or waits for a disk.
void EndAtOnce(int)
{
  constexpr char text[] = ": stopped at once; the next run removes what is left of this one\n";
  const bool isTold = ::write(STDERR_FILENO, ToolName, std::strlen(ToolName)) > 0 &&
    ::write(STDERR_FILENO, text, sizeof(text) - 1) > 0;
  ::_exit(isTold ? 130 : 131);
}

void Catch(int signal, void (*handler)(int), int flags)
{
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  ::sigaction(signal, &action, nullptr);
}

} // namespace

void CatchStopSignals(const char* tool)
{
  ToolName = tool;
  constexpr int once = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  Catch(SIGINT, TakeStopSignal, once);
  Catch(SIGTERM, TakeStopSignal, once);
  Catch(SIGALRM, EndAtOnce, 0);
  Catch(SIGXFSZ, SIG_IGN, 0); // a file that may not grow is an error of writing it
}

void ReleaseStopSignals()
{
  ::alarm(0);
  Catch(SIGINT, SIG_DFL, 0);
  Catch(SIGTERM, SIG_DFL, 0);
}

bool IsStopAsked()
{
  if (StopAsked != 0)
  {
    // The work ends in good order, however long it takes to remove what it has begun.
    ::alarm(0);
    return true;
  }
  return false;
}

} // namespace isosurface
