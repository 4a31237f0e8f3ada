// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/ThreadPriority.h"

#ifdef __linux__
#  include <sys/resource.h>
#  include <sys/syscall.h>
#  include <unistd.h>
#endif

namespace isosurface
{

void LowerThreadPriority()
{
#ifdef __linux__
  constexpr int lower = 5;
  // Linux has a nice value for each thread. Without it the work is done as well.
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  const int priority = getpriority(PRIO_PROCESS, thread);
  static_cast<void>(setpriority(PRIO_PROCESS, thread, priority + lower));
#endif
}

} // namespace isosurface
