// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChunkedSource_h
#define isosurface_ChunkedSource_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/PageBuffer.h"
#include "Ground/Volume/ValueType.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Store/SourceSamples.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// How a file is decoded while it is read as a whole.
struct ChunkDecoding
{
  std::uint64_t MemoryBytes = 0; ///< for decoded chunks, and for what threads take
  int Threads = 1;
  /// As long as it is true, chunks that are decoded go to the cache of the process, too; null: never. It is asked for
  /// each of them, and may wait.
  std::function<bool()> IsShared{};
  /// All that is read, by one Read(); empty: all is read, slab by slab.
  VertexBox Part{};
};

/// A file that is read box by box, whose chunks several threads decode (SourceSamples).
class ChunkedSource : public BoxSource
{
public:
  /**
   * Puts such a source in place of `source`, a file as it was opened by its name (VolumeName), if its
   * chunks can be decoded by several threads, and the memory is enough for two layers of them and for two
   * threads. `record`: which part of the file is read; of the volume `path` if chunks are shared.
   * Errors: those of opening the file again.
   */
  static Status Replace(std::unique_ptr<BoxSource>& source, FileSystem& files, VolumeOpener opener,
    const std::string& path, const std::string& name, const SourceRecord& record,
    const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const ChunkDecoding& decoding);

  const VertexBox& GetBox() const override { return this->Source->GetBox(); }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override { return this->HeldBytes; }
  std::int64_t GetRowsAtOnce() const override { return this->Source->GetRowsAtOnce(); }
  std::optional<Index3> GetChunk() const override { return this->Source->GetChunk(); }
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  ChunkedSource() = default;
  /// Decodes a slab of the box, which needs few enough chunks, and copies it to its place in an image of
  /// the box for each component.
  Status ReadSlab(const VertexBox& slab, const VertexBox& box, std::uint8_t* to);

  std::shared_ptr<SourceSamples> Samples;
  std::unique_ptr<BoxSource> Source; ///< tells in which order to read, and is not read
  std::vector<ValueType> Types;      ///< of the components of all arrays
  std::uint64_t HeldBytes = 0;
  int Threads = 1;
  std::int64_t Slices = 1; ///< whose chunks are decoded and kept at once
  std::shared_ptr<PageBufferPool> Pool = std::make_shared<PageBufferPool>();
};

} // namespace isosurface

#endif
