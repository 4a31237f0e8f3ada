// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredBlockSource_h
#define isosurface_StoredBlockSource_h

#include "Ground/Volume/BlockSource.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace isosurface
{

/// What an extraction takes of a block: its decoded variables are the contoured one, then the components
/// of the arrays to interpolate.
BlockSamples MakeBlockSamples(
  DecodedBlocks blocks, const ArrayVariables& variables, const std::vector<std::size_t>& arrays);

/**
 * Blocks of a blocked volume on disk, for an extraction. Each is read when it is acquired, through
 * the block cache, and released afterwards; meanwhile the disk reads ahead. The blocks must have
 * the level (FindLevel); coordinates are those of the level. The volume must outlive the source.
 *
 * Cost of Acquire: BlockedVolume::ReadVariables, of the variable and of all components of the
 * arrays to interpolate.
 */
class StoredBlockSource : public BlockSource
{
public:
  /// The decoded bytes of the blocks that are read ahead of the acquired one.
  static constexpr std::uint64_t ReadAheadBytes = std::uint64_t{ 16 } << 20;

  StoredBlockSource(BlockedVolume& volume, std::size_t timeStep, std::size_t variable, int level,
    std::vector<BlockReference> blocks);

  /// Sets further arrays to interpolate, in the order of the attributes. Inactive blocks are read
  /// without them.
  void SetAttributes(std::vector<std::size_t> arrays);

  /// Only the cells of this part of the level are extracted (BlockSelection::Part).
  void SetPart(const std::optional<VertexBox>& part) { this->Part = part; }

  /// Only the blocks [begin, end) will certainly be acquired, in this order: only they are expected
  /// and read ahead. Otherwise all are.
  void SetOwnBlocks(std::size_t begin, std::size_t end);
  /// Starts reading other blocks, which will be acquired soon.
  void ReadOthersAhead(std::size_t begin, std::size_t end);

  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override;
  VertexBox GetVertices(std::size_t block) const override;
  ValueType GetValueType() const override;
  Result<BlockSamples> Acquire(std::size_t block) override;

  /// The cost of the blocks acquired so far, of all threads.
  QueryStatistics GetStatistics() const;

private:
  void ReadAhead(std::size_t block);
  void ExpectOwnBlocks();

  BlockedVolume& Volume;
  std::size_t TimeStep;
  std::size_t VariableNumber;
  std::vector<std::size_t> Attributes; ///< arrays
  Status AttributesStatus;
  std::vector<std::size_t> Variables; ///< the contoured one, then the attributes' components
  int Level;
  StoredLevel Stored;
  std::vector<BlockReference> Blocks;
  std::optional<VertexBox> Part;
  std::size_t OwnBegin = 0;
  std::size_t OwnEnd;

  std::once_flag Expected;
  std::mutex ReadAheadMutex;
  std::size_t EndOfReadAhead = 0;
  std::size_t BlocksAhead = 0; ///< of ReadAheadBytes

  mutable std::mutex StatisticsMutex;
  QueryStatistics Statistics;
};

} // namespace isosurface

#endif
