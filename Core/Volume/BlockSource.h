// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSource_h
#define isosurface_BlockSource_h

#include "Base/Status.h"
#include "Volume/BlockGrid.h"
#include "Volume/SampleView.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/// Tuples that stand on the edges of a block's vertices already, for the points there to take as
/// they are: one for the edge from the vertex (i, j, k) of Box along each axis, x fastest, without
/// gaps, of any alignment. Only crossed edges have one.
struct EdgeTupleView
{
  ValueType Type = ValueType::Float32; ///< Float32 or Float64, as interpolated values are
  int NumberOfComponents = 1;
  std::array<const std::uint8_t*, 3> First{};
  VertexBox Box;
};

/// A further array of a block, in one of two ways.
struct AttributeView
{
  /// Samples at the vertices, to be interpolated: one view a component, all of one type.
  std::vector<SampleView> Components;
  /// If given, these instead; there are no Components then. Such an array is not known at vertices:
  /// sides of the grid cannot be closed, and a point that a vertex keeps (DropDegenerateTriangles)
  /// has the tuple of its own edge.
  std::optional<EdgeTupleView> EdgeTuples{};
};

/// Where the surface crosses the edges of a block's vertices: how far along the edge (0 to 1) from
/// the vertex (i, j, k) of Box along each axis, x fastest. Only crossed edges have a value.
struct CrossingView
{
  std::array<const float*, 3> First{};
  VertexBox Box;
};

/// The samples of a block, in grid coordinates, for as long as Owner is held.
struct BlockSamples
{
  SampleView Scalars; ///< Box is the block's vertices
  std::vector<AttributeView> Attributes;
  /// If given, points lie there, and the scalars tell only the sides of the isovalue.
  const CrossingView* Crossings = nullptr;
  std::shared_ptr<const void> Owner; ///< empty if the memory outlives the extraction anyway
};

/**
 * The blocks of a grid that an extraction is to visit: a part of a lattice of boxes, of any size,
 * of which neighbours (lattice coordinates that differ by one on an axis) share a face of vertices.
 * Blocks with equal lattice coordinates on an axis span the same vertices on it.
 *
 * The source counts its blocks from 0; blocks of the grid that no isovalue can cross are left out.
 */
class BlockSource
{
public:
  virtual ~BlockSource() = default;

  virtual std::size_t GetNumberOfBlocks() const = 0;
  virtual Index3 GetLatticeCoordinates(std::size_t block) const = 0;

  /// The block's vertices, shared faces included, counted from 0 at the grid's first vertex.
  virtual VertexBox GetVertices(std::size_t block) const = 0;

  /// The type of the scalars of all blocks.
  virtual ValueType GetValueType() const = 0;

  /**
   * The block's samples. Called once for each block, in no certain order, by several threads at
   * once; the samples are let go before the same thread asks for another block. Available covers
   * the block, and one layer more where the grid has one if normals are asked for.
   */
  virtual Result<BlockSamples> Acquire(std::size_t block) = 0;
};

} // namespace isosurface

#endif
