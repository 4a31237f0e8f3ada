// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WindowCounters_h
#define isosurface_WindowCounters_h

#include "Ground/Base/SharedCounters.h"

#include <memory>

class vtkMultiProcessController;

namespace isosurface
{

/**
 * Counters in an MPI window: ranks reach them without the help of their owner on one machine, where
 * they are in shared memory, and over networks that know remote atomic operations. Over others, such
 * as TCP, MPI serves them while their owner is in a call of MPI (LetOthersIn). Collective.
 *
 * Null on all ranks if one of them does not want counters, the controller is no vtkMPIController,
 * has one rank, not all ranks of the job, or counters in use, or a rank gets no window. Cost: one reduction; at the first
 * call for an MPI communicator a window and a communicator, which are kept as long as it lives.
 */
std::unique_ptr<SharedCounters> MakeWindowCounters(
  vtkMultiProcessController* controller, bool wanted);

} // namespace isosurface

#endif
