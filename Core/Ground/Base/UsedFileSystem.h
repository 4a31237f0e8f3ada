// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_UsedFileSystem_h
#define isosurface_UsedFileSystem_h

#include "Ground/Base/FileSystem.h"

namespace isosurface
{

/// From now on GetLocalFileSystem() gives this one. For a module with a copy of this code of its own: with the
/// file system of the library that has loaded it, it shares descriptors and stops (ReadingStop).
extern "C" void IsosurfaceUseFileSystem(FileSystem& fileSystem);

} // namespace isosurface

#endif
