// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PointAttributes_h
#define isosurface_PointAttributes_h

#include "Coding/BlockCoding/AttributeCoder.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Buffer.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/Surface.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Owns the tuples of point arrays at the edges of a block: for each attribute of the header and
/// each axis one tuple for each vertex (AttributeEdges), also where the edge is not crossed.
class PointAttributes
{
public:
  PointAttributes(const EdgeIndexHeader& header, const VertexBox& vertices);

  /// The attributes as the coder takes them; they point into this object, as views do.
  std::vector<CodedAttribute> GetCoded() const { return this->Coded; }

  /// The attributes as an extraction takes them, for a block with this box of vertices.
  std::vector<AttributeView> GetViews(
    const EdgeIndexHeader& header, const VertexBox& vertices) const;

  /**
   * Interpolates the arrays, and computes normals, at the crossed edges of a block, as
   * ExtractSurface does. samples.Attributes: the arrays of the header in their order, without
   * normals, of any type whose GetInterpolatedType is the header's.
   *
   * Errors: InvalidArgument (other arrays, no ghost layer around the block for normals).
   */
  Status Interpolate(
    const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue);

private:
  std::vector<std::array<Buffer<std::uint8_t>, 3>> Tuples;
  std::vector<CodedAttribute> Coded;
};

/**
 * Reverses normals if the direction of the grid is mirrored: streams have those of vtkFlyingEdges3D,
 * which then point to high values, as in release 1.0.0.
 */
void TurnStoredNormals(const GridGeometry& grid, Buffer<float>& normals);

/// The layouts of the header's attributes, including normals.
std::vector<AttributeLayout> GetAttributeLayouts(const EdgeIndexHeader& header);

} // namespace isosurface

#endif
