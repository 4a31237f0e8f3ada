// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredBoxSource_h
#define isosurface_StoredBoxSource_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BoxSource.h"
#include "Storage/Sampling/LevelSamples.h"
#include "Storage/Store/BlockedVolume.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The samples of a blocked volume at full resolution, box by box, so that it can be written anew
 * with other settings. Every store must be within this process's reach.
 *
 * Cost of Read: BlockedVolume::ReadBlock of each block that the box touches, for each component.
 * Slices of one layer of blocks are decoded once if the block cache holds the layer.
 */
class StoredBoxSource : public BoxSource
{
public:
  /// Of the volume's arrays those with the given numbers, in that order: a view for each component.
  /// Boxes are read on `threads` threads. Reads the directories of all stores; errors as
  /// LevelSamples::Open. Shares the volume.
  static Result<std::unique_ptr<StoredBoxSource>> Make(const std::shared_ptr<BlockedVolume>& volume,
    std::size_t timeStep, const std::vector<std::size_t>& arrays, int threads);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  StoredBoxSource() = default;

  std::shared_ptr<const LevelSamples> Samples;
  std::vector<std::size_t> Variables; ///< a view for each
  VertexBox Box;
  int Threads = 1;
};

} // namespace isosurface

#endif
