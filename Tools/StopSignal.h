// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StopSignal_h
#define isosurface_StopSignal_h

namespace isosurface
{

/// From now on SIGINT and SIGTERM ask to stop; the second one of a kind ends the process at once.
void CatchStopSignals();

/// Whether one of them came.
bool IsStopAsked();

} // namespace isosurface

#endif
