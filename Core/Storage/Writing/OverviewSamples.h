// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OverviewSamples_h
#define isosurface_OverviewSamples_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/PageBuffer.h"
#include "Storage/Writing/BlockExchange.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// The vertices of an overview that one block of the finer volume supplies, in the overview's
/// coordinates. Each vertex of the overview belongs to one block.
VertexBox FindOverviewPart(const BlockGrid& finer, std::int64_t block);

/// Copies the samples of these vertices, array after array, x fastest, from a block's record before
/// its segments are encoded.
std::vector<std::uint8_t> PickOverviewSamples(
  const BlockGrid& finer, const std::vector<ValueType>& types, const PendingBlock& block);

/**
 * The samples of an overview, for the writer of the overview. The writers of the finer volume leave
 * them in temporary files: one a store, in the finer volume's folder, with the samples
 * (PickOverviewSamples) of the blocks of the store, by ascending block index, without gaps.
 *
 * Each rank reads from all files: one read for each layer of blocks and store. Memory: 4 bytes a
 * block of the finer volume, 8 a layer of blocks and store.
 */
class OverviewSource : public BoxSource
{
public:
  static std::string GetPath(const std::string& folder, std::size_t store);

  /// `blockStores`: the store of each block of the finer volume, which has `stores` stores.
  /// `folder`: where the files are.
  OverviewSource(FileSystem& files, std::string folder, const BlockGrid& finer,
    std::vector<ValueType> types, std::vector<std::uint32_t> blockStores, std::size_t stores);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  /// Blocks of one layer, in whole rows [Begin, End), of one store.
  struct BlockRun
  {
    std::uint64_t Offset = 0; ///< in the store's file
    std::uint64_t Size = 0;
    std::vector<std::int64_t> Blocks;
  };

  std::uint64_t GetBlockBytes(std::int64_t block) const;
  std::size_t FindStore(std::int64_t block) const
  {
    return this->BlockStores[static_cast<std::size_t>(block)];
  }
  /// The block on an axis that supplies a vertex.
  std::int64_t FindBlock(std::int64_t vertex, std::size_t axis) const;
  std::vector<BlockRun> FindRuns(
    std::int64_t layer, std::int64_t beginRow, std::int64_t endRow) const;
  /// Copies the samples of a part within a box to their places in samples[array].
  Status ReadRun(const BlockRun& part, std::size_t store, const VertexBox& box,
    const std::vector<std::uint8_t*>& samples);

  FileSystem& Files;
  std::string Folder;
  BlockGrid Finer;
  VertexBox Box;
  std::vector<ValueType> Types;
  std::uint64_t VertexBytes = 0; ///< of all arrays
  std::vector<std::uint32_t> BlockStores;
  std::size_t Stores;
  std::vector<std::uint64_t> LayerOffsets; ///< per layer of blocks and store: where its parts begin
  Buffer<std::uint8_t> PartBytes;          ///< of the last part, for the next one
  std::shared_ptr<PageBufferPool> Pool;
};

} // namespace isosurface

#endif
