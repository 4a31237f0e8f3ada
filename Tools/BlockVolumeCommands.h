// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockVolumeCommands_h
#define isosurface_BlockVolumeCommands_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"

namespace isosurface
{

/// Prints the contents of a blocked volume, as text or JSON.
Status RunInfoCommand(const BlockVolumeOptions& options);

/// Prints the datasets, variables, arrays or series of the input, one a line.
Status RunListCommand(const BlockVolumeOptions& options);

/// Restores the lost and damaged stores of a blocked volume, and prints which. Error: Corrupt if
/// some of them cannot be restored, with a line for each to standard error; those of
/// RepairBlockedVolume.
Status RunRepairCommand(const BlockVolumeOptions& options);

/// Tells a blocked volume in place where its source is now. Prints the result.
Status RunSourceCommand(const BlockVolumeOptions& options);

/// Checks a blocked volume and prints every fault to standard error. Error: Corrupt if there are any.
Status RunVerifyCommand(const BlockVolumeOptions& options);

/// Writes the blocked volume that the options ask for. Collective; rank 0 prints the result.
Status RunWriteCommand(const BlockVolumeOptions& options, Communicator& ranks);

} // namespace isosurface

#endif
