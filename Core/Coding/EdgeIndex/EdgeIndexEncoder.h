// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexEncoder_h
#define isosurface_EdgeIndexEncoder_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * Encodes isosurfaces as edge indices: X. Zhang and C. Bajaj, "Scalable isosurface
 * visualization of massive datasets on commodity off-the-shelf clusters", J. Parallel Distrib.
 * Comput. 2009, section 4.2. A point of the surface is a crossed edge of the grid and the values at
 * its ends. Deviation: not bitmaps of vertices and cells are coded, but the sign of every vertex,
 * which implies both (SignCoder); values are predicted from neighbours, not along a row.
 *
 * Blocks are encoded independently: by several threads, each with an encoder, and decoded in any
 * order. The bytes depend on the block and the header only. Memory: the model (at most 2 MB), the
 * signs of the block, and three slices.
 */
class EdgeIndexEncoder
{
public:
  /// The header must be valid (EdgeIndexHeader::Check).
  explicit EdgeIndexEncoder(const EdgeIndexHeader& header);
  ~EdgeIndexEncoder();
  EdgeIndexEncoder(const EdgeIndexEncoder&) = delete;
  EdgeIndexEncoder& operator=(const EdgeIndexEncoder&) = delete;

  /**
   * Appends the record of one block at one isovalue, after that of its part of the preview. Appends
   * nothing if the isovalue does not cross the block. samples.Scalars.Box: the block's vertices, at
   * most 65 on an axis; lattice: see BlockSource::GetLatticeCoordinates.
   *
   * Errors: InvalidArgument.
   */
  Status EncodeBlock(const Index3& lattice, const BlockSamples& samples, std::size_t isovalue,
    std::vector<std::uint8_t>& bytes);

private:
  class Work; ///< the header and the models
  std::unique_ptr<Work> Worker;
};

/**
 * Encodes the blocks of a source at all isovalues. Calls `take`, from the calling thread, with the
 * records of some blocks at a time: in the order of the source, the records of a block by isovalue,
 * for any number of threads. An error that `take` returns ends the encoding.
 *
 * Errors: InvalidArgument, what Acquire or `take` returns, OutOfMemory, Aborted. Memory for each
 * thread: an encoder, and the records of 64 blocks.
 */
Status EncodeBlocks(const EdgeIndexHeader& header, BlockSource& source, int threads,
  const std::function<Status(const std::vector<std::uint8_t>& records)>& take,
  const Progress& progress = {});

} // namespace isosurface

#endif
