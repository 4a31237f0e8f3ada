// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StandardOutput_h
#define isosurface_StandardOutput_h

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Brings what was printed to standard output. IoError if any of it was lost.
Status FlushStandardOutput();

} // namespace isosurface

#endif
