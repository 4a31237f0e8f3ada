// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GlbFile_h
#define isosurface_GlbFile_h

#include "Coding/Meshes/MeshFile.h"

namespace isosurface
{

/// A file of binary glTF 2.0 (MeshFile::Create), whose source alone needs a library of JSON.
Result<std::unique_ptr<MeshFile>> CreateGlbFile(std::unique_ptr<WritableFile> file,
  const EdgeIndexHeader& header, const MeshFile::Settings& settings);

} // namespace isosurface

#endif
