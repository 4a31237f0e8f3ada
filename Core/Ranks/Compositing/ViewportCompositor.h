// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ViewportCompositor_h
#define isosurface_ViewportCompositor_h

#include "Ground/Base/Communicator.h"
#include "Ranks/Compositing/CompositePlan.h"
#include "Ranks/Compositing/PixelRuns.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// Where a rank that shows a tile gets its image: buffers of the tile's size in pixels, not owned.
struct TileImage
{
  std::uint32_t* Colors = nullptr;
  float* Depths = nullptr; ///< null if no depths are wanted
};

/**
 * Merges the images that the ranks drew in their viewports into the images of the display's tiles,
 * by direct send. Of the active samples at a pixel the nearest one is seen; among equally near ones,
 * that of the highest rank. Pixels without an active sample get color 0 and depth 1.
 *
 * Images are sent in the resolution that they were drawn in, and only their active pixels: with
 * depths to the owners of cells where images meet, without to the ranks that show the tiles (see
 * CompositePlan). The result does not depend on who owns what.
 *
 * Compare: C. Neumann, "Communication costs for parallel volume-rendering algorithms", IEEE CG&A
 * 1994, direct send with sparse merging; here the regions follow the viewports' edges.
 *
 * Keeps its buffers from frame to frame. Memory: an image of the cells that the rank owns, the
 * messages and, with antialiasing, the tile in samples.
 */
class ViewportCompositor
{
public:
  /**
   * Collective. `viewports` are those of all ranks; `mine` is the image of this rank's viewport,
   * whose raster is the viewport's blocks (null pointers if that is empty). `tile` is filled on the
   * ranks that show a tile, at most one each. `wantsDepths` is the same on all ranks.
   *
   * An error of one rank is one of all: InvalidArgument if an image, the memory for a tile, or a
   * tile's rank is missing; Corrupt if a message is. The tiles' images are undefined then.
   */
  Status Composite(Communicator& communicator, const DisplayLayout& display,
    const std::vector<Viewport>& viewports, const ImageView& mine, const TileImage& tile,
    bool wantsDepths);

  /// Bytes that this rank sent to other ranks in the last frame.
  std::uint64_t GetBytesSent() const { return this->BytesSent; }

private:
  std::vector<Message> Send(Communicator& communicator, std::vector<Message> outgoing);
  std::vector<Message> EncodeSamples(
    int me, const std::vector<Viewport>& viewports, const ImageView& mine) const;
  Status MergeOwnedCells(int me, const std::vector<Viewport>& viewports, const ImageView& mine,
    const std::vector<Message>& samples);
  std::vector<Message> EncodeMergedCells(int me, std::size_t ranks, const ImageView& mine) const;
  Status FillTile(
    int me, const ImageView& mine, const std::vector<Message>& merged, const TileImage& tile);
  Status FillSamples(const DisplayTile& shown, const ImageView& mine,
    const std::vector<Message>& merged, const TileImage& samples);
  ImageView GetMergedImage(std::size_t cell, const ImageView& mine) const;

  DisplayLayout Display;
  std::vector<CompositeCell> Cells;
  std::vector<ImageBuffer> Owned; ///< by cell; empty where this rank does not merge
  PixelContent Delivered = PixelContent::Colors;
  ActivePixels Received;
  ImageBuffer TileSamples; ///< with antialiasing
  std::uint64_t BytesSent = 0;
};

} // namespace isosurface

#endif
