// SPDX-License-Identifier: BSD-3-Clause
#include "ReaderCrash.h"

#include <algorithm>
#include <csignal>
#include <cstddef>

#include <unistd.h>

namespace isosurface
{
namespace
{

constexpr int Signals[] = { SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT };
constexpr std::size_t NumberOfSignals = sizeof(Signals) / sizeof(Signals[0]);

// Nothing may be allocated in a handler.
char CrashMessage[1024];
std::size_t CrashMessageSize = 0;
struct sigaction Before[NumberOfSignals];

void TellOfCrash(int signal)
{
  static_cast<void>(::write(STDERR_FILENO, CrashMessage, CrashMessageSize) > 0);
  // The handler is reset: this ends the process.
  static_cast<void>(::raise(signal));
}

} // namespace

ReaderCrash::ReaderCrash(const std::string& message)
{
  CrashMessageSize = std::min(message.size(), sizeof(CrashMessage) - 1);
  std::copy_n(message.begin(), CrashMessageSize, CrashMessage);
  CrashMessage[CrashMessageSize++] = '\n';
  struct sigaction action = {};
  action.sa_handler = TellOfCrash;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  for (std::size_t number = 0; number < NumberOfSignals; ++number)
  {
    ::sigaction(Signals[number], &action, &Before[number]);
  }
}

ReaderCrash::~ReaderCrash()
{
  for (std::size_t number = 0; number < NumberOfSignals; ++number)
  {
    ::sigaction(Signals[number], &Before[number], nullptr);
  }
}

} // namespace isosurface
