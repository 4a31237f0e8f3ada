// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChunkedSource_h
#define isosurface_ChunkedSource_h

#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/PageBuffer.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Store/SourceSamples.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/// How a file is decoded while it is read as a whole.
struct ChunkDecoding
{
  std::uint64_t CacheBytes = 0; ///< what chunks may take that are decoded
  int Threads = 1;
  std::shared_ptr<BlockCache> SharedCache; ///< where they stay for others, too; or null
};

/// A file that is read box by box, whose chunks several threads decode (SourceSamples).
class ChunkedSource : public BoxSource
{
public:
  /// Puts such a source in place of `source`, a file as it was opened, unless there is nothing to decode,
  /// it can only be read in order, or a layer of chunks does not fit into the cache. `record` describes
  /// it for the volume `path`. Errors: those of SourceSamples::Open.
  static Status Replace(std::unique_ptr<BoxSource>& source, FileSystem& files, VolumeOpener opener,
    const std::string& path, const SourceRecord& record, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, const ChunkDecoding& decoding);

  const VertexBox& GetBox() const override { return this->Source->GetBox(); }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  std::int64_t GetRowsAtOnce() const override { return this->Source->GetRowsAtOnce(); }
  std::optional<Index3> GetChunk() const override { return this->Source->GetChunk(); }
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  ChunkedSource(std::shared_ptr<SourceSamples> samples, std::unique_ptr<BoxSource> source,
    std::vector<ValueType> types, const ChunkDecoding& decoding);

  const std::shared_ptr<SourceSamples> Samples;
  const std::unique_ptr<BoxSource> Source; ///< tells in which order to read, and is not read
  const std::vector<ValueType> Types;      ///< of the components of all arrays
  const ChunkDecoding Decoding;
  const std::shared_ptr<PageBufferPool> Pool = std::make_shared<PageBufferPool>();
};

} // namespace isosurface

#endif
