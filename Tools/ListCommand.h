// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ListCommand_h
#define isosurface_ListCommand_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Prints the datasets, variables, arrays or series of the input, one a line.
Status RunListCommand(const BlockVolumeOptions& options);

} // namespace isosurface

#endif
