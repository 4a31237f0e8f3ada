// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockSource_h
#define isosurface_BlockSource_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/Blanking.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleView.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/// Tuples on the edges of a block. The points on these edges take them without interpolation.
/// First[axis] has one tuple for the edge along the axis from each vertex (i, j, k) of Box, x
/// fastest, without gaps, at any alignment. Only the tuples of crossed edges are defined.
struct EdgeTupleView
{
  ValueType Type = ValueType::Float32; ///< Float32 or Float64, like interpolated values
  int NumberOfComponents = 1;
  std::array<const std::uint8_t*, 3> First{};
  VertexBox Box;
};

/// An array of a block other than the contoured one, either at the vertices or on the edges.
struct AttributeView
{
  /// Samples at the vertices, to be interpolated: one view for each component, all of one type.
  std::vector<SampleView> Components;
  /// Tuples on the edges; Components is empty then. Since the values at the vertices are unknown,
  /// sides of the grid cannot be closed, and a point that is moved to a vertex
  /// (DropDegenerateTriangles) keeps the tuple of its edge.
  std::optional<EdgeTupleView> EdgeTuples{};
};

/// Where the surface crosses the edges of a block: First[axis] has, for the edge along the axis
/// from each vertex (i, j, k) of Box, x fastest, the position of the point on the edge (0 to 1).
/// Only the values of crossed edges are defined; if IsOfFaces, only of those in the faces of Box, and
/// the scalars tell where all other points lie.
struct CrossingView
{
  std::array<const float*, 3> First{};
  VertexBox Box;
  bool IsOfFaces = false;
};

/// The samples of a block, in grid coordinates. They are valid as long as Owner is held.
struct BlockSamples
{
  SampleView Scalars; ///< Box is the block's vertices
  std::vector<AttributeView> Attributes;
  /// If given, the points lie there, and the scalars tell which vertices are inside.
  const CrossingView* Crossings = nullptr;
  /// If given, what is hidden. Its Box contains the block.
  const Blanking* Hidden = nullptr;
  std::shared_ptr<const void> Owner; ///< may be empty if the memory outlives the extraction
};

/**
 * The blocks of a grid that an extraction visits. They are some of the boxes of a lattice, of any
 * size. Neighbours (lattice coordinates that differ by one on an axis) share a face of vertices.
 * Blocks with the same lattice coordinate on an axis span the same vertices on it.
 *
 * The source numbers its blocks from 0. It may leave out blocks that are not active.
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
   * Returns the samples of a block. Called once for each block, in any order, by several threads at
   * once. A thread releases the samples before it acquires the next block. Available covers the
   * block; if normals are requested, one more layer around it where the grid has one.
   */
  virtual Result<BlockSamples> Acquire(std::size_t block) = 0;
};

} // namespace isosurface

#endif
