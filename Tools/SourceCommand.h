// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceCommand_h
#define isosurface_SourceCommand_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Tells a blocked volume in place where its source is now. Prints the result.
Status RunSourceCommand(const BlockVolumeOptions& options);

} // namespace isosurface

#endif
