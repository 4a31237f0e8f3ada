// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_InfoCommand_h
#define isosurface_InfoCommand_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Prints the contents of a blocked volume, as text or JSON.
Status RunInfoCommand(const BlockVolumeOptions& options);

} // namespace isosurface

#endif
