// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RawSource_h
#define isosurface_RawSource_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/PageBuffer.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace isosurface
{

/**
 * The samples of one array in a file, x fastest, then y, then z. Cost of a box: one read for whole
 * slices, or one for each if their size is a multiple of 4096 bytes (ChooseSlicePitch); a read for
 * each slice for whole rows, otherwise a read for each row.
 */
class RawSource : public BoxSource
{
public:
  /// The file contains all samples and nothing before them. `heldBytes`: the memory of `file`.
  RawSource(std::unique_ptr<RandomAccessFile> file, const Index3& size, ValueType type,
    bool isBigEndian, std::uint64_t heldBytes);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override { return this->HeldBytes; }
  std::optional<Index3> GetChunk() const override;
  bool HasCheapRows() const override { return this->HeldBytes == 0; } // no stream
  /// Whole slices.
  void Prefetch(const VertexBox& box) const override;
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  Status ReadSamples(const VertexBox& box, std::uint8_t* to) const;

  std::unique_ptr<RandomAccessFile> File;
  VertexBox Box;
  ValueType Type;
  bool IsBigEndian;
  std::uint64_t HeldBytes;
  std::shared_ptr<PageBufferPool> Pool;
};

} // namespace isosurface

#endif
