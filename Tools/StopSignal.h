// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StopSignal_h
#define isosurface_StopSignal_h

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Opens the null device as standard input, output and error where they are closed. Otherwise the next
/// files that are opened, by any library, take their numbers, and get what is printed.
void OpenStandardStreams();

/// Brings what was printed to standard output. IoError if any of it was lost.
Status FlushStandardOutput();

/// From now on SIGINT and SIGTERM ask to stop. If nothing asks IsStopAsked() within a second, or at a
/// second signal of a kind, the process ends at once; so a command ends also while a library opens a
/// file. `tool`: the name for the message.
void CatchStopSignals(const char* tool);

/// The work has ended, and was told: from now on such a signal ends the process without a word. mpiexec sends
/// one to ranks that end later than another rank that has failed.
void ReleaseStopSignals();

/// Whether such a signal arrived. Who is told so must stop.
bool IsStopAsked();

} // namespace isosurface

#endif
