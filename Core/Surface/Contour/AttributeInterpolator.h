// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributeInterpolator_h
#define isosurface_AttributeInterpolator_h

#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/BrickKernel.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * Interpolates the samples of an attribute linearly along edges of a brick, in double. Writes one
 * tuple after the other, as values of the interpolated type (GetInterpolatedType).
 *
 * codes, parameters: `count` edges, and the position of the point on each edge (0 to 1); low: the
 * brick's first vertex; tuples: room for count * number of components values, aligned for the type.
 */
void InterpolateAttribute(const AttributeView& view, const Index3& low, const EdgeCode* codes,
  const double* parameters, std::size_t count, std::uint8_t* tuples);

/// Copies the tuples of edges. No code may be that of a vertex.
void CopyEdgeTuples(const EdgeTupleView& view, const Index3& low, const EdgeCode* codes,
  std::size_t count, std::uint8_t* tuples);

} // namespace isosurface

#endif
