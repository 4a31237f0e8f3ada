// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexDecoder_h
#define isosurface_EdgeIndexDecoder_h

#include "Coding/EdgeIndex/BlockIslands.h"
#include "Coding/EdgeIndex/BlockRecordFormat.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"

#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

struct BlockModel;

/**
 * Decodes the records of one stream, by any number of threads at once, into samples that marching
 * cubes contours to the encoded surface: each has the right side of the isovalue; as far as the mode
 * keeps them, the ends of crossed edges have the right values; in bounded mode the positions of
 * points on their edges are there; and the tuples of the attributes.
 *
 * Memory: a model (at most 2 MB) for each thread that decodes, and the samples.
 */
class EdgeIndexBlockDecoder
{
public:
  /// header: that of the stream, or its MakePreview() for blocks of the preview; must outlive the
  /// decoder.
  explicit EdgeIndexBlockDecoder(const EdgeIndexHeader& header);
  ~EdgeIndexBlockDecoder();
  EdgeIndexBlockDecoder(const EdgeIndexBlockDecoder&) = delete;
  EdgeIndexBlockDecoder& operator=(const EdgeIndexBlockDecoder&) = delete;

  /// Errors: Corrupt.
  Result<BlockSamples> Decode(const EdgeIndexRecord& record);

  /// The islands of the decoded blocks that lack some, which the samples still have; see KeepBlockIslands.
  const std::vector<BlockIsland>& GetIslands() const { return this->Islands; }

private:
  Status TellIslands(const EdgeIndexRecord& record, const BlockSamples& samples);
  std::unique_ptr<BlockModel> TakeModel();

  const EdgeIndexHeader& Header;
  std::mutex Mutex;
  std::vector<std::unique_ptr<BlockModel>> Models; ///< not in use by a thread
  std::vector<BlockIsland> Islands;
};

} // namespace isosurface

#endif
