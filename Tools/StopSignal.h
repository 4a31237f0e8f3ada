// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StopSignal_h
#define isosurface_StopSignal_h

namespace isosurface
{

/// From now on SIGINT and SIGTERM ask to stop; a second signal of a kind ends the process at once.
void CatchStopSignals();

/// Whether such a signal arrived.
bool IsStopAsked();

} // namespace isosurface

#endif
