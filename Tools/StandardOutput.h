// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StandardOutput_h
#define isosurface_StandardOutput_h

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Opens the null device as standard input, output and error where they are closed. Otherwise the next
/// files that are opened, by any library, take their numbers, and get what is printed.
void OpenStandardStreams();

/// Brings what was printed to standard output. IoError if any of it was lost.
Status FlushStandardOutput();

} // namespace isosurface

#endif
