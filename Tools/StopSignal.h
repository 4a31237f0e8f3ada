// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StopSignal_h
#define isosurface_StopSignal_h

namespace isosurface
{

/// From now on SIGINT and SIGTERM ask to stop. If nothing asks IsStopAsked() within a second, or at a
/// second signal of a kind, the process ends at once; so a command ends also while a library opens a
/// file. `tool`: the name for the message.
void CatchStopSignals(const char* tool);

/// Whether such a signal arrived. Who is told so must stop.
bool IsStopAsked();

} // namespace isosurface

#endif
