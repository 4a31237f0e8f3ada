// SPDX-License-Identifier: BSD-3-Clause
#include "StopSignal.h"

#include <csignal>

namespace isosurface
{
namespace
{

volatile std::sig_atomic_t StopAsked = 0;

void TakeStopSignal(int)
{
  StopAsked = 1;
}

} // namespace

void CatchStopSignals()
{
  struct sigaction action = {};
  action.sa_handler = TakeStopSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

bool IsStopAsked()
{
  return StopAsked != 0;
}

} // namespace isosurface
