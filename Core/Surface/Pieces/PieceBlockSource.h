// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PieceBlockSource_h
#define isosurface_PieceBlockSource_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Coding.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/GridSides.h"
#include "Ground/Volume/PieceOwnership.h"
#include "Ground/Volume/Region.h"
#include "Ground/Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/// A piece of a grid that a rank has in memory. The views of all arrays have the boxes of Scalars.
struct GridPiece
{
  SampleView Scalars;
  std::vector<AttributeView> Attributes;
};

/// Which blocks of a grid a PieceBlockSource has.
struct PieceBlockSelection
{
  std::vector<double> Isovalues;
  isosurface::Region Region;
  GridSides ClosedSides;            ///< all blocks that touch these are taken, too
  const GridLines* Lines = nullptr; ///< of a rectilinear grid; null: of a regular one
  int BlockSize = 64;               ///< 16, 32 or 64 cells
  bool WithLayer = false; ///< whether Available covers a layer around each block, for gradients
};

/// What this rank gives a PieceBlockSource. The pieces are in the coordinates of the grid (from 0).
struct PieceBlockInput
{
  GridGeometry Grid; ///< the same on all ranks, as is Selection
  std::vector<GridPiece> Pieces;
  PieceBlockSelection Selection;
};

/**
 * The active blocks of a grid of which the ranks have pieces in memory, of any shape, overlapping
 * ones included. The blocks are those of the grid as a whole, so blocks and samples do not depend
 * on how the grid was cut. A block within a piece is a view of that piece. A block that pieces
 * share belongs to the first rank that has some of it, which is sent the samples that it lacks, each
 * from the first piece that has it. All Available samples of a piece count, so ghost layers fill gaps.
 *
 * Memory besides the pieces, which must outlive the source: the samples of the shared active blocks
 * of this rank.
 */
class PieceBlockSource : public BlockSource
{
public:
  /**
   * One source for each input, all by two gathers and an exchange. `prepared`: whether this rank has the
   * inputs, as many as all ranks. Collective. Cost: one pass over the samples of the selected blocks.
   *
   * Errors, of any rank: that of `prepared`, OutOfMemory. Others are those of a source (GetStatus).
   */
  static Result<std::vector<std::unique_ptr<PieceBlockSource>>> MakeAll(
    Communicator& ranks, const Status& prepared, std::vector<PieceBlockInput> inputs, int threads);
  /// One source; its errors are those of all ranks.
  static Result<std::unique_ptr<PieceBlockSource>> Make(
    Communicator& ranks, PieceBlockInput input, int threads);

  /// InvalidArgument, on all ranks, for pieces of different types, or between which an active block has a gap;
  /// this rank's OutOfMemory; RemoteFailure if another rank had no memory to send samples. Then nothing
  /// can be acquired.
  const Status& GetStatus() const { return this->Fault; }

  /// The numbers of this rank's blocks in the BlockGrid of the whole grid, ascending.
  const std::vector<std::int64_t>& GetNumbers() const { return this->Numbers; }

  /// The finite values of all blocks of the selected region, active or not, of all ranks.
  const KeyRange& GetFiniteRange() const { return this->Finite; }

  std::size_t GetNumberOfBlocks() const override { return this->Numbers.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Grid.GetBlockCoordinates(this->Numbers[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Grid.GetVertices(this->Numbers[block]);
  }
  ValueType GetValueType() const override { return this->Types.front(); }
  Result<BlockSamples> Acquire(std::size_t block) override;

private:
  /// Whose a piece is.
  struct PieceOwner
  {
    int Rank = 0;
    std::size_t Number = 0; ///< of that rank's
  };

  /// A block that no piece has as a whole.
  struct SharedBlock
  {
    std::int64_t Number = 0;
    int Owner = 0;
    VertexBox Samples; ///< that the owner needs
    std::vector<Supply> Supplies;
    bool HasGap = false;
    /// On which sides of each isovalue's threshold it has samples: on both, if it is active.
    std::vector<std::uint8_t> Sides;
    std::vector<Buffer<std::uint8_t>> Arrays; ///< on the owner: one a component
  };

  /// Where an own block's samples are: in a piece, or in a shared block.
  struct Place
  {
    bool IsShared = false;
    std::size_t Index = 0;
  };

  PieceBlockSource(const GridGeometry& geometry, std::vector<GridPiece> pieces,
    const PieceBlockSelection& selection);
  /// Describes the pieces of this rank to the others; and adds the pieces of all ranks.
  Message DescribePieces() const;
  void AddPieces(std::vector<ByteReader>& readers);
  Status AddPiecesOf(int rank, ByteReader reader);
  void FindBlocks(int rank, const PieceBlockSelection& selection, int threads);
  /// Tells the others the range of this rank's samples, and on which sides of the isovalues those of shared blocks
  /// are; and takes what all tell.
  void AppendRanges(int rank, Message& message);
  void TakeRanges(std::vector<ByteReader>& readers);
  static void ShareSamples(
    Communicator& ranks, const std::vector<std::unique_ptr<PieceBlockSource>>& sources);
  void PackShared(int rank, std::vector<Message>& outgoing);
  Status PlaceShared(int rank, std::vector<ByteReader>& readers);
  bool IsAtClosedSide(std::int64_t number) const;
  /// The views of all components of a piece: scalars first.
  std::vector<SampleView> GetViews(std::size_t piece) const;

  GridGeometry Geometry;
  BlockGrid Grid;
  bool WithLayer;
  GridSides ClosedSides;
  std::vector<double> Isovalues;
  std::vector<ValueKey> Thresholds;
  std::vector<GridPiece> Pieces;
  std::vector<PieceOwner> AllPieces; ///< of all ranks, by rank
  std::vector<VertexBox> Boxes;      ///< of all samples that these pieces have
  std::vector<ValueType> Types;      ///< of the scalars, then of each attribute's components
  std::vector<int> AttributeSizes;   ///< components of each attribute
  std::vector<SharedBlock> Shared;
  std::vector<std::int64_t> Numbers;
  std::vector<Place> Places; ///< of the blocks of Numbers
  KeyRange Finite;
  Status Fault;
};

} // namespace isosurface

#endif
