// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VerifyCommand_h
#define isosurface_VerifyCommand_h

#include "BlockVolumeOptions.h"

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Checks a blocked volume and prints every fault to standard error. Error: Corrupt if there are any.
Status RunVerifyCommand(const BlockVolumeOptions& options);

} // namespace isosurface

#endif
