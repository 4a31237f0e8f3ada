// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceUnpacking_h
#define isosurface_SurfaceUnpacking_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ranks/Redistribution/ArrivingBlocks.h"
#include "Surface/Contour/Surface.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace isosurface
{

/// Makes the surface of arriving blocks in a thread of its own, so that the calling thread can go
/// on exchanging messages with other ranks.
class SurfaceUnpacking
{
public:
  /// Starts the thread. Header and request must outlive the object. Throws std::system_error if the
  /// thread cannot be started.
  SurfaceUnpacking(const EdgeIndexHeader& header, const ContourRequest& request,
    std::vector<BlockDescription> blocks, int threads);
  /// Stops the thread, whether it has finished or not.
  ~SurfaceUnpacking();
  SurfaceUnpacking(const SurfaceUnpacking&) = delete;
  SurfaceUnpacking& operator=(const SurfaceUnpacking&) = delete;

  ArrivingBlocks& GetBlocks() { return this->Blocks; }
  /// The fraction that is done, 0 to 1.
  double GetShare() const { return this->Share; }
  /// The surface, once all blocks have arrived; calls `progress` while it waits.
  Result<Surface> Finish(const Progress& progress);

private:
  Result<Surface> Unpack(const EdgeIndexHeader& header, const ContourRequest& request, int threads);

  ArrivingBlocks Blocks;
  std::atomic<double> Share{ 0 };
  std::atomic<bool> Stopped{ false };
  std::mutex Mutex;
  std::condition_variable Done;
  std::optional<Result<Surface>> Outcome;
  std::thread Thread; ///< last, since it uses all the others
};

} // namespace isosurface

#endif
