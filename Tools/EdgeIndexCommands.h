// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexCommands_h
#define isosurface_EdgeIndexCommands_h

#include "EdgeIndexOptions.h"

#include "Ground/Base/Status.h"

namespace isosurface
{

/// Prints the contents of a file, which it knows from header and directory alone.
Status RunEdgeIndexInfo(const EdgeIndexOptions& options);

/// Decodes every block. Error: Corrupt, with the reason, if a block is faulty or missing.
Status RunEdgeIndexVerify(const EdgeIndexOptions& options);

/// Decodes a file and writes its triangles. Error: InvalidArgument for an unknown file extension.
Status RunEdgeIndexDecode(const EdgeIndexOptions& options);

} // namespace isosurface

#endif
