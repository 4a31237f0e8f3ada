// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceSamples_h
#define isosurface_SourceSamples_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/VertexBox.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * The samples of a time step of a volume in place: boxes at full resolution, gathered from the chunks
 * of the source (SourceRecord). Chunks are decoded when a box needs them, and kept in the block cache
 * as any blocks; a chunk that several threads need at once is decoded once. Different chunks are
 * decoded by several threads at once where the source's library allows it.
 *
 *       chunks of the source          a block with its ghost layer
 *       +-------+-------+-------+
 *       |     +-|-----+ |       |     takes a part of each chunk that it touches; the last chunks
 *       +-----|-+-----|-+-------+     may be partial, and missing ones have the fill value
 *       |     +-|-----+ |       |
 *       +-------+-------+-------+
 *
 * Safe for any number of threads.
 */
class SourceSamples
{
public:
  /// Opens the source of a time step of the volume `path`, and checks that it is as it was when it was
  /// indexed (CheckSource). `files` must outlive this.
  static Result<std::shared_ptr<SourceSamples>> Open(FileSystem& files, VolumeOpener opener,
    const std::string& path, const SourceRecord& record, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, std::shared_ptr<BlockCache> cache);
  /// The same of a volume that is to be written, of a source by its name (VolumeName), without that check.
  static Result<std::shared_ptr<SourceSamples>> OpenNew(FileSystem& files, VolumeOpener opener,
    const std::string& path, const std::string& name, const SourceRecord& record,
    const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    std::shared_ptr<BlockCache> cache);
  /// From now on, gives the chunks that it decodes to another cache as well, as long as isShared().
  void ShareWith(std::shared_ptr<BlockCache> cache, std::function<bool()> isShared);
  SourceSamples(const SourceSamples&) = delete;
  SourceSamples& operator=(const SourceSamples&) = delete;
  ~SourceSamples() { this->Cache->Release(this->Dataset); }

  /// Writes the samples of a component in a box within the grid to `to`: x fastest, without gaps.
  /// Cost: decoding the chunks that the box touches and that are not in the cache; the bytes that
  /// were decoded count as read.
  Status Read(
    std::size_t component, const VertexBox& box, std::uint8_t* to, QueryStatistics& statistics);

  /// The samples of a component in a block of level 0, behind `front` bytes that are left free. `part`: no
  /// others are read, not even of the ghost layer; null: all.
  Result<std::shared_ptr<DecodedBlock>> ReadBlock(std::size_t component, const BlockGrid& grid,
    std::int64_t block, std::size_t front, QueryStatistics& statistics,
    const VertexBox* part = nullptr);

  /// Decodes the chunks of a component that a box needs and that are not in the cache, each by one of so
  /// many threads.
  Status Decode(std::size_t component, const VertexBox& box, int threads);

  /// The slices of the deepest chunks.
  std::int64_t GetChunkSlices() const;
  /// The bytes in a cache of all chunks that at most `slices` adjacent slices of a box need.
  std::uint64_t GetSlabBytes(const VertexBox& box, std::int64_t slices) const;
  /// The bytes that a thread takes while it decodes a chunk.
  std::uint64_t GetThreadBytes() const;

  ValueType GetType(std::size_t component) const
  {
    return this->Arrays[this->ArrayOf[component]].Type;
  }
  /// The source's name, for messages.
  const std::string& GetName() const { return this->Name; }
  /// Ok if the source's files are as they were when it was indexed (CheckSourceFiles).
  Status CheckUnchanged() const;
  /// The error, Corrupt, for a block whose samples differ from those that were indexed.
  Status MakeChanged(std::int64_t block) const;

private:
  /// An array of the source.
  struct Array
  {
    std::string Name;
    ValueType Type = ValueType::UInt8;
    std::size_t FirstComponent = 0;
    std::size_t Components = 1;
    Index3 Chunk = { 1, 1, 1 };
    Index3 Chunks = { 1, 1, 1 }; ///< on each axis
    std::uint64_t HeldBytes = 0; ///< of one that is open
    /// Others are forked from it, so it is never read; null if the source cannot be forked.
    std::unique_ptr<BoxSource> Parent;
    /// Open ones that no thread reads at the moment.
    std::vector<std::unique_ptr<BoxSource>> Idle;
  };
  using Chunk = std::shared_ptr<const DecodedBlock>;

  SourceSamples(FileSystem& files, VolumeOpener opener, std::string volume,
    const SourceRecord& record, std::shared_ptr<BlockCache> cache)
    : Files(files)
    , Opener(opener)
    , Volume(std::move(volume))
    , Record(record)
    , Dataset(record.ComputeDataset())
    , Cache(std::move(cache))
  {
    this->Cache->Retain(this->Dataset);
  }

  /// `paths` (may be null): the files of the source.
  Result<std::unique_ptr<BoxSource>> OpenArray(
    const Array& array, std::vector<std::string>* paths = nullptr) const;
  Result<std::unique_ptr<BoxSource>> Take(Array& array);
  void GiveBack(Array& array, std::unique_ptr<BoxSource> source);
  VertexBox FindChunkBox(const Array& array, const Index3& chunk) const;
  /// All components of an array in a chunk, one after another, each x fastest.
  Result<Chunk> DecodeChunk(Array& array, const VertexBox& box);
  std::vector<Index3> FindChunks(const Array& array, const VertexBox& box) const;
  Result<Chunk> GetChunk(Array& array, const Index3& chunk, QueryStatistics& statistics);
  BlockCacheKey MakeKey(const Array& array, const Index3& chunk) const;
  /// Copies what a chunk has of a component in a box.
  Status CopyChunk(Array& array, const Index3& chunk, std::size_t component, const VertexBox& box,
    std::uint8_t* to, QueryStatistics& statistics);

  FileSystem& Files;
  VolumeOpener Opener;
  std::string Volume; ///< path of the .bvol
  std::string Name;
  SourceRecord Record;
  std::vector<std::string> Paths; ///< of the source's files
  std::uint64_t Dataset;
  std::shared_ptr<BlockCache> Cache;
  std::shared_ptr<BlockCache> SharedCache; ///< or null
  std::function<bool()> IsShared;          ///< null without one
  VertexBox Box;                           ///< of the grid
  std::vector<Array> Arrays;
  std::vector<std::size_t> ArrayOf; ///< per component
  std::mutex Mutex;                 ///< of Array::Idle
};

/**
 * A component of a block of a volume in place: the samples are those of the source, behind the segment's
 * `header`, which the store has. The block has one level, whose samples are not compressed. `path`: the
 * file with the header, for messages. Corrupt if the samples are not those that were indexed; the error
 * names the source.
 */
Result<std::shared_ptr<const DecodedBlock>> GatherBlock(SourceSamples& source,
  const BlockGrid& grid, const BlockDirectoryEntry& entry, const std::string& path,
  std::size_t component, const std::uint8_t* header, QueryStatistics& statistics);

} // namespace isosurface

#endif
