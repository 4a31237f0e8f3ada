// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemorySource_h
#define isosurface_MemorySource_h

#include "Ground/Volume/BoxSource.h"

#include <vector>

namespace isosurface
{

/**
 * The piece of a volume that a rank has in memory: the vertices of Box, counted from 0 at the
 * grid's first vertex, and a view for each array whose Available contains Box. Box may be empty.
 */
struct VolumePiece
{
  VertexBox Box;
  std::vector<SampleView> Arrays;
};

/// Samples in memory. Read() copies nothing. The samples must outlive the source.
class MemorySource : public BoxSource
{
public:
  explicit MemorySource(const VolumePiece& piece)
    : Piece(piece)
  {
  }

  const VertexBox& GetBox() const override { return this->Piece.Box; }
  std::uint64_t GetReadBytes(const VertexBox&) const override { return 0; }
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  VolumePiece Piece;
};

} // namespace isosurface

#endif
