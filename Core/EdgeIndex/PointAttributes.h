// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointAttributes_h
#define isosurface_PointAttributes_h

#include "Base/Buffer.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "EdgeIndex/AttributeCoder.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockSource.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The point arrays of a block at its edges, and the memory that they stand in: for each attribute
 * of the header, and each axis, a tuple a vertex (see AttributeEdges). Only those of crossed edges
 * are ever touched.
 */
class PointAttributes
{
public:
  PointAttributes(const EdgeIndexHeader& header, const VertexBox& vertices);

  const std::vector<AttributeEdges>& GetEdges() const { return this->Edges; }

  /// The arrays as an extraction takes them, of a block with this box of vertices.
  std::vector<AttributeView> GetViews(
    const EdgeIndexHeader& header, const VertexBox& vertices) const;

  /**
   * Interpolates the arrays (and computes normals) at the crossed edges of a block, as
   * ExtractSurface does; samples.Attributes are the samples of the header's attributes but for
   * normals, in their order, of any type that becomes the header's (GetInterpolatedType).
   *
   * Errors: InvalidArgument (other arrays, no layer around the block for normals).
   */
  Status Interpolate(
    const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue);

private:
  std::vector<std::array<Buffer<std::uint8_t>, 3>> Tuples;
  std::vector<AttributeEdges> Edges;
};

/// The layouts of the header's attributes, normals among them.
std::vector<AttributeLayout> GetAttributeLayouts(const EdgeIndexHeader& header);

} // namespace isosurface

#endif
