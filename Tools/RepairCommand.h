// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RepairCommand_h
#define isosurface_RepairCommand_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Restores the lost and damaged stores of a blocked volume, and prints which. Error: Corrupt if
/// some of them cannot be restored, with a line for each to standard error; those of
/// RepairBlockedVolume.
Status RunRepairCommand(const BlockVolumeOptions& options);

} // namespace isosurface

#endif
