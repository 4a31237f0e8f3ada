// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ThreadPriority_h
#define isosurface_ThreadPriority_h

namespace isosurface
{

/**
 * Gives the calling thread, and those that it starts, about a third of the processor time of other
 * threads of the process where there are not enough processors for all. On Linux; elsewhere, and if
 * the system refuses, threads stay as they are.
 */
void LowerThreadPriority();

} // namespace isosurface

#endif
