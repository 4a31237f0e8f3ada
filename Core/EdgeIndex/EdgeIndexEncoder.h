// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexEncoder_h
#define isosurface_EdgeIndexEncoder_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace isosurface
{

struct BlockModel;

/**
 * Edge-index encoding of isosurfaces: X. Zhang, C. Bajaj and W. Blanke, "Scalable isosurface
 * visualization of massive datasets on commodity off-the-shelf clusters", J. Parallel Distrib.
 * Comput. 2009, section 4.2. A point of the surface is a crossed edge of the grid and the values at
 * its ends. Deviation: not bitmaps of relevant vertices and valid cells are coded but the sign of
 * every vertex, which tells both (see SignCoder); values in a neighbourhood, not in a row.
 *
 * Encodes one block after another, each on its own: blocks can be encoded by several threads, with
 * an encoder each, sent as they are done, and decoded in any order. The bytes depend on the block
 * and the header only.
 *
 * Memory: that of the model (at most 1 MB), the signs of the block, and three slices.
 */
class EdgeIndexEncoder
{
public:
  /// The header must be valid (EdgeIndexHeader::Check). For training only: with `learning`, a model
  /// of the header's profile, blocks are coded by it and it goes on learning.
  explicit EdgeIndexEncoder(const EdgeIndexHeader& header, BlockModel* learning = nullptr);
  ~EdgeIndexEncoder();
  EdgeIndexEncoder(const EdgeIndexEncoder&) = delete;
  EdgeIndexEncoder& operator=(const EdgeIndexEncoder&) = delete;

  /**
   * Appends the record of one block at one isovalue to `bytes`, that of the preview before it, or
   * nothing where the isovalue does not cross it. samples.Scalars.Box is the block's vertices, at
   * most 65 on an axis; `lattice` its place among the blocks (BlockSource::GetLatticeCoordinates).
   *
   * Errors: InvalidArgument.
   */
  Status EncodeBlock(const Index3& lattice, const BlockSamples& samples, std::size_t isovalue,
    std::vector<std::uint8_t>& bytes);

private:
  class Work;
  std::unique_ptr<Work> Worker;
};

/**
 * Encodes the blocks of a source at all isovalues, and hands the records of some blocks at a time
 * to `take`, from the calling thread: in the order of the source, of a block by isovalue, whatever
 * the number of threads. What take returns if not Ok ends the encoding.
 *
 * Errors: InvalidArgument, whatever Acquire or take returns, OutOfMemory, Aborted. Memory: an
 * encoder a thread, and the records of 16 blocks a thread.
 */
Status EncodeBlocks(const EdgeIndexHeader& header, BlockSource& source, int threads,
  const std::function<Status(const std::vector<std::uint8_t>& records)>& take,
  const Progress& progress = {});

/// The surface of a source as one stream: the header, then the records as EncodeBlocks has them.
/// Errors: as EncodeBlocks.
Result<std::vector<std::uint8_t>> EncodeSurface(
  const EdgeIndexHeader& header, BlockSource& source, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
