// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SharedDepths_h
#define isosurface_SharedDepths_h

#include "Surface/Drawing/BoxProjection.h"
#include "Surface/Drawing/DepthPyramid.h"

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * The depths of triangles that ranks tell each other while they draw an image. So a rank leaves out the
 * triangles that are behind those of others (VisibleRuns).
 *
 * Each rank tells its depths once: when the last mapper has drawn the triangles that were visible in the image
 * before; without such a mapper, when all triangles are drawn. So the ranks meet at the same place, whatever else
 * communicates while it is drawn.
 */
class SharedDepths
{
public:
  /// Reduces numbers to the maxima of all ranks. Collective; false on all ranks if it cannot be done.
  using ReduceMaximum = std::function<bool(std::vector<std::uint64_t>&)>;

  /// Of the image that is drawn; null if there are no other ranks.
  static SharedDepths* GetCurrent();
  static void SetCurrent(SharedDepths* depths);

  /// Begins an image, of a size in pixels, of which this rank draws `part`. `last`: the mapper that is
  /// drawn last, or null. Memory: 12 bytes for each 4 x 4 pixels. If it runs out, nothing is wanted.
  void Begin(int width, int height, const PixelBox& part, const void* last);
  /// Lets the ranks tell each other.
  void Connect(ReduceMaximum reduce) { this->ReduceAll = std::move(reduce); }
  /// For mappers that leave triangles out, when they have read depths; only the last one gets
  /// anything. The first time it tells the other ranks of `drawn`: collective after Connect(). Brings
  /// `drawn` nearer where something is in front of it.
  void Share(const void* mapper, DepthPyramid& drawn);
  /// Whether it pays to connect the image: the mapper that is drawn last would share. It has shared
  /// before, perhaps before images of other sizes or of other mappers, as while the camera moves.
  bool IsWanted() const { return this->Last && this->Last == this->Sharer; }
  /// Ends the image: collective after Connect(), on ranks that have not shared.
  void End();

private:
  void Tell(const std::vector<float>& squares);
  void ReduceOnce();

  int Width = 0;
  int Height = 0;
  PixelBox Part;
  const void* Last = nullptr;
  const void* Sharer = nullptr; ///< the mapper that shared when it could last
  ReduceMaximum ReduceAll;      ///< null if it was called, or is not to be
  /// By square: the bits of the farthest depth, inverted, so that nearer is more; 0: nothing is told.
  std::vector<std::uint64_t> Told;
  std::vector<float> Farthest; ///< by square, of what all ranks told
};

} // namespace isosurface

#endif
