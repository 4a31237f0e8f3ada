// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceForm_h
#define isosurface_SurfaceForm_h

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "Redistribution/ArrivingBlocks.h"
#include "Redistribution/BlockDescription.h"
#include "Volume/BlockSource.h"

#include <functional>

namespace isosurface
{

/// In what form the surfaces of blocks travel between ranks.
class SurfaceForm
{
public:
  virtual ~SurfaceForm() = default;

  /// Given one block after another, from the calling thread.
  using Take = std::function<Status(BlockDescription block, Message bytes)>;

  /// The blocks of a source as bytes, in its order, those without a surface left out. Errors: what
  /// Acquire or take returns, InvalidArgument, Aborted; std::bad_alloc is thrown.
  virtual Status Pack(
    BlockSource& source, int threads, const Take& take, const Progress& progress) const = 0;

  /// The surface of blocks, each taken when it is there. Errors: Corrupt, OutOfMemory, Aborted
  /// (also if not all blocks come); std::bad_alloc is thrown.
  virtual Result<Surface> Unpack(
    ArrivingBlocks& blocks, int threads, const Progress& progress) const = 0;
};

} // namespace isosurface

#endif
