// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PieceLayers_h
#define isosurface_PieceLayers_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A piece of one of several grids that a rank has in memory.
struct LayeredPiece
{
  std::size_t Grid = 0;
  Index3 Dimensions{}; ///< of the grid
  SampleView Scalars;  ///< Box is what the piece contours
  Blanking Hidden;
};

/**
 * What the pieces of grids have to know of each other for normals without seams: the samples of the
 * layer around each piece's Box that the piece itself does not have, but another one does, on
 * whichever rank.
 */
class PieceLayers
{
public:
  PieceLayers() = default;

  /// Collective. Cost: a box of each piece to all ranks, and the samples of the layers, a byte more
  /// for each. `prepared`: whether this rank has `pieces`. Errors: that of any rank; OutOfMemory of any rank or of
  /// this one; RemoteFailure if another rank had no memory to send samples. The caller has all ranks agree.
  static Result<PieceLayers> Collect(
    Communicator& ranks, const Status& prepared, const std::vector<LayeredPiece>& pieces);

  /// Makes room for `pieces` pieces without layers.
  void Resize(std::size_t pieces) { this->Layers.resize(pieces); }

  /// A box of the layer around a piece.
  struct LayerBox
  {
    int Rank = 0; ///< that had the samples
    VertexBox Box;
    Buffer<std::uint8_t> Samples;     ///< x fastest
    std::vector<std::uint8_t> Hidden; ///< 1 for a sample that is hidden
  };

  /// The layer around a piece of this rank; empty if it needs none, or if no rank has any.
  const std::vector<LayerBox>& GetLayer(std::size_t piece) const { return this->Layers[piece]; }

private:
  /// Takes the samples of all parts from the messages of the ranks.
  Status Place(const std::vector<Message>& incoming);

  std::vector<std::vector<LayerBox>> Layers;
};

/**
 * Blocks of a piece, those at its border with the layer around it. Where a part of that layer is
 * missing, its samples count as hidden. What this refers to must outlive it.
 */
class LayeredBlockSource : public BlockSource
{
public:
  LayeredBlockSource(
    BlockSource& inner, const LayeredPiece& piece, const std::vector<PieceLayers::LayerBox>& layer);

  /// The vertices that gradients may use: ContourRequest::KnownSamples.
  VertexBox GetKnownSamples() const;

  std::size_t GetNumberOfBlocks() const override { return this->Inner.GetNumberOfBlocks(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Inner.GetLatticeCoordinates(block);
  }
  VertexBox GetVertices(std::size_t block) const override { return this->Inner.GetVertices(block); }
  ValueType GetValueType() const override { return this->Inner.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override;

private:
  struct Copy;

  BlockSource& Inner;
  const LayeredPiece& Piece;
  const std::vector<PieceLayers::LayerBox>& Layer;
};

} // namespace isosurface

#endif
