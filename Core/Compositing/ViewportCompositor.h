// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ViewportCompositor_h
#define isosurface_ViewportCompositor_h

#include "Base/Communicator.h"
#include "Compositing/CompositePlan.h"
#include "Compositing/PixelRuns.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// Where a rank that shows a tile gets its picture: buffers of the tile's size, not owned.
struct TileImage
{
  std::uint32_t* Colors = nullptr;
  float* Depths = nullptr; ///< null if nobody asks for them, on all ranks alike
};

/// What one frame cost this rank.
struct CompositeCost
{
  std::uint64_t BytesSent = 0;
  std::uint64_t PixelsMerged = 0; ///< samples of cells that this rank owns, of all ranks' pictures
  double EncodeSeconds = 0;
  double ExchangeSeconds = 0; ///< waiting for others included
  double MergeSeconds = 0;
  double DeliverSeconds = 0; ///< of putting what was merged in place
};

/**
 * Merges the pictures that ranks drew of their viewports into those of the display's tiles: of all
 * active samples of a pixel the nearest one is seen; among equally near ones, that of the highest
 * rank. A sample counts for all pixels of its block. Pixels without an active sample become 0,
 * their depth 1.
 *
 * Images travel in the resolution that they were drawn in, and nothing is sent but active pixels:
 * with depths to the owners of cells where pictures meet, without to the ranks that show the tiles.
 * (See CompositePlan.) The result does not depend on who owns what.
 *
 * Compare: C. Neumann, "Communication costs for parallel volume-rendering algorithms", IEEE CG&A
 * 1994, direct send with sparse merging; here the regions follow the viewports' edges.
 *
 * Keeps its buffers from frame to frame. Memory: a picture of what the rank owns, and the messages.
 */
class ViewportCompositor
{
public:
  /**
   * Collective. `viewports` are those of all ranks; `mine` is the picture of this rank's, whose
   * raster is the viewport's blocks (null pointers if that is empty). `tile` is filled on the ranks
   * that show a tile; a rank shows one at most. `wantsDepths` is the same on all ranks.
   *
   * An error of one rank is one of all: InvalidArgument if a picture, a place for one, or a tile's
   * rank is missing; Corrupt if a message is. The tiles' pictures are undefined then.
   */
  Status Composite(Communicator& communicator, const std::vector<Viewport>& viewports,
    const std::vector<DisplayTile>& tiles, const ImageView& mine, const TileImage& tile,
    bool wantsDepths);

  const CompositeCost& GetCost() const { return this->Cost; }

private:
  struct OwnedImage
  {
    std::vector<std::uint32_t> Colors;
    std::vector<float> Depths;
    ImageView View;
  };

  std::vector<Message> Send(Communicator& communicator, std::vector<Message> outgoing);
  std::vector<Message> EncodePieces(
    int me, const std::vector<Viewport>& viewports, const ImageView& mine);
  Status MergeOwnedCells(int me, const std::vector<Viewport>& viewports, const ImageView& mine,
    const std::vector<Message>& pieces);
  std::vector<Message> EncodeMergedCells(int me, const ImageView& mine);
  Status FillTile(
    int me, const ImageView& mine, const std::vector<Message>& merged, const TileImage& tile);
  const ImageView& GetMergedImage(std::size_t cell, const ImageView& mine) const;

  std::size_t NumberOfRanks = 0;
  std::vector<DisplayTile> Tiles;
  std::vector<CompositeCell> Cells;
  std::vector<OwnedImage> Owned; ///< by cell; empty where this rank does not merge
  PixelContent Delivered = PixelContent::Colors;
  ActivePixels Received;
  CompositeCost Cost;
};

} // namespace isosurface

#endif
