// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleCopy_h
#define isosurface_SampleCopy_h

#include "Ground/Volume/SampleView.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// A view of an array with a tuple of `components` values for each vertex of a box, x fastest;
/// `first` is the component of the first tuple to view.
SampleView MakeSampleView(
  ValueType type, const VertexBox& box, const void* first, std::int64_t components = 1);

/// The same samples, but only those of vertices whose coordinates are multiples of 2^level: a view of
/// that level's grid. May be empty.
SampleView Coarsen(const SampleView& view, int level);

/// Copies `count` samples of `size` bytes (1, 2, 4 or 8); strides are in samples.
void CopySamples(void* to, std::ptrdiff_t toStride, const void* from, std::ptrdiff_t fromStride,
  std::int64_t count, std::size_t size);

/// Copies the samples of `part`, which may be empty, to their places in an array of all vertices of
/// `whole`, x fastest. Successive vertices of the array are `stride` samples apart.
void CopyBox(const SampleView& from, const VertexBox& part, const VertexBox& whole, void* to,
  std::ptrdiff_t stride = 1);

} // namespace isosurface

#endif
