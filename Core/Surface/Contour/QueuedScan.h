// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_QueuedScan_h
#define isosurface_QueuedScan_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockQueue.h"
#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/BrickScan.h"

#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * The first phase of an extraction whose blocks become known only during it. Each block is scanned
 * as if it had no neighbours. When all are known, points that a neighbour owns are dropped, so the
 * result is that of BrickScan::Run for the same blocks, in the order of their numbers in the
 * source.
 *
 * Cost beside that of BrickScan: points on the faces of blocks that meet are made more than once.
 */
class QueuedScan
{
public:
  QueuedScan(const GridGeometry& geometry, BlockSource& source, const ContourRequest& request,
    BrickScan& scan)
    : Geometry(geometry)
    , Source(source)
    , Request(request)
    , Scan(scan)
  {
  }

  /// Scans all blocks of the queue into the scan; returns their lattice. Errors: those of the
  /// queue, of BrickLattice::Cut and of BrickScan::Run.
  Result<BrickLattice> Run(BlockQueue& queue, int threads, const Progress& progress);

private:
  /// A block with its results, which count its bricks alone.
  struct ScannedBlock
  {
    std::size_t Block;
    BrickScan::Parts Parts;
  };

  Status ScanBlock(std::size_t block, int thread);
  Status ScanAll(BlockQueue& queue, int threads, const Progress& progress);
  /// Puts the results of all blocks in their order.
  void Join(const BrickLattice& lattice);
  void DropWhatOthersOwn(const BrickLattice& lattice, int threads);

  const GridGeometry& Geometry;
  BlockSource& Source;
  const ContourRequest& Request;
  BrickScan& Scan;
  std::mutex Mutex; ///< guards the blocks
  std::vector<ScannedBlock> Scanned;
};

} // namespace isosurface

#endif
