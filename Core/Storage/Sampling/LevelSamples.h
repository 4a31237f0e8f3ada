// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LevelSamples_h
#define isosurface_LevelSamples_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/VertexBox.h"
#include "Storage/Sampling/BlockAssembly.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * The samples of one level of a blocked volume at one time step, found by their place. Every store
 * must be within this process's reach. Vertices are those of the level: level-0 coordinates /
 * 2^level. Functions may be called by several threads at once.
 */
class LevelSamples
{
public:
  /// Reads the directories of the stores that have the level. Errors: of BlockedVolume::ListBlocks;
  /// Corrupt if a block is in no store.
  static Result<std::shared_ptr<const LevelSamples>> Open(
    std::shared_ptr<BlockedVolume> volume, std::size_t timeStep, int level);

  BlockedVolume& GetVolume() const { return *this->Volume; }
  std::size_t GetTimeStep() const { return this->TimeStep; }
  int GetLevel() const { return this->Level; }
  /// The blocks that have the level.
  const BlockGrid& GetBlockGrid() const { return *this->Stored.Grid; }
  /// In bytes: 32 a block of the level.
  std::uint64_t GetMemory() const { return this->Blocks.capacity() * sizeof(BlockReference); }
  /// All vertices of the level.
  VertexBox GetBox() const;

  /// The blocks that have the vertices of a box within GetBox().
  BlockBox FindCover(const VertexBox& vertices) const;
  /// The block coordinates of the first block that has the cell with this low vertex; of vertices
  /// on the high faces, the last one.
  Index3 FindBlock(const Index3& vertex) const;
  /// The low vertices of the cells for which FindBlock gives a block.
  VertexBox FindCells(const Index3& block) const;
  /// Where the block with these block coordinates is stored.
  const BlockReference& GetBlock(const Index3& block) const;

  /**
   * Fills `samples` with one variable at every step-th vertex of a box within GetBox(), from the
   * box's low corner on, x fastest. Successive samples are `stride` apart, so that the components of
   * an array can be interleaved. `step`: at least 1 on each axis.
   *
   * Reads each block that has such a vertex once, through the block cache, on `threads` threads.
   * Errors: of BlockedVolume::ReadBlock; Aborted.
   */
  Status Read(std::size_t variable, const VertexBox& box, const Index3& step, int threads,
    void* samples, std::ptrdiff_t stride, QueryStatistics& statistics,
    const Progress& progress = {}) const;

private:
  LevelSamples() = default;

  /// Read() of a source at an address: the chunks that the box crosses, and not all of each block's.
  Status ReadSource(std::size_t variable, const VertexBox& box, const Index3& step, void* samples,
    std::ptrdiff_t stride, QueryStatistics& statistics, const Progress& progress) const;
  /// Cells of a block on an axis, unless it is the last one.
  std::int64_t GetBlockSide() const
  {
    return this->Stored.Grid->GetBlockSize() >> this->Stored.Level;
  }

  std::shared_ptr<BlockedVolume> Volume;
  std::size_t TimeStep = 0;
  int Level = 0;
  StoredLevel Stored;
  std::vector<BlockReference> Blocks; ///< by block index
};

/// The levels of a volume that samples are read of, each opened once; of another volume, anew. At most 64
/// levels of time steps are kept. Functions may be called by several threads at once.
class LevelsOfVolume
{
public:
  /// Errors: LevelSamples::Open.
  Result<std::shared_ptr<const LevelSamples>> Find(
    const std::shared_ptr<BlockedVolume>& volume, std::size_t timeStep, int level);

private:
  std::mutex Mutex; ///< guards Levels
  std::map<std::pair<std::size_t, int>, std::shared_ptr<const LevelSamples>> Levels;
};

/// Makes the values of a variable: `stride` values apart, from `first` on.
using ComponentSampler =
  std::function<Status(std::size_t variable, void* first, int stride, const Progress& progress)>;

/// Calls `sample` for each component of some arrays one after another; `values` has the tuples of each of
/// these arrays.
Status SampleComponents(const ArrayVariables& variables, const std::vector<std::size_t>& arrays,
  const std::vector<void*>& values, const Progress& progress, const ComponentSampler& sample);

} // namespace isosurface

#endif
