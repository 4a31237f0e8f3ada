// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WriteCommand_h
#define isosurface_WriteCommand_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"

namespace isosurface
{

/// Writes the blocked volume that the options ask for. Collective; rank 0 prints the result.
Status RunWriteCommand(const BlockVolumeOptions& options, Communicator& ranks);

} // namespace isosurface

#endif
