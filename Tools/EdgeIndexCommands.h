// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexCommands_h
#define isosurface_EdgeIndexCommands_h

#include "EdgeIndexOptions.h"

#include "Base/Status.h"

namespace isosurface
{

/// Tells on standard output what a file has, from its header and directory alone.
Status RunEdgeIndexInfo(const EdgeIndexOptions& options);

/// Decodes every block. Corrupt, with the reason, if one is faulty or something is missing.
Status RunEdgeIndexVerify(const EdgeIndexOptions& options);

/// Decodes a file to triangles, and writes them. InvalidArgument for an ending that is not known.
Status RunEdgeIndexDecode(const EdgeIndexOptions& options);

} // namespace isosurface

#endif
