// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceUnpacking_h
#define isosurface_SurfaceUnpacking_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "Redistribution/ArrivingBlocks.h"
#include "Redistribution/SurfaceForm.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace isosurface
{

/**
 * Makes the surface of arriving blocks in a thread of its own, so that the one that talks to other
 * ranks goes on.
 */
class SurfaceUnpacking
{
public:
  /// Begins. The form must outlive it. Throws std::system_error if there is no further thread.
  SurfaceUnpacking(const SurfaceForm& form, std::vector<BlockDescription> blocks, int threads);
  /// Ends it, finished or not.
  ~SurfaceUnpacking();
  SurfaceUnpacking(const SurfaceUnpacking&) = delete;
  SurfaceUnpacking& operator=(const SurfaceUnpacking&) = delete;

  ArrivingBlocks& GetBlocks() { return this->Blocks; }
  /// The share that is done, 0 to 1.
  double GetShare() const { return this->Share; }
  /// The surface, when all blocks have arrived; until then `progress` is told.
  Result<Surface> Finish(const Progress& progress);

private:
  Result<Surface> Unpack(const SurfaceForm& form, int threads);

  ArrivingBlocks Blocks;
  std::atomic<double> Share{ 0 };
  std::atomic<bool> Stopped{ false };
  std::mutex Mutex;
  std::condition_variable Done;
  std::optional<Result<Surface>> Outcome;
  std::thread Thread; ///< last, for it uses all the rest
};

} // namespace isosurface

#endif
