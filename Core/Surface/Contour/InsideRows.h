// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_InsideRows_h
#define isosurface_InsideRows_h

#include "Ground/Volume/SampleView.h"

#include <cstdint>

namespace isosurface
{

/// Finds which samples of a box, of at most 64 columns, are at least the threshold, a number of
/// their type: bit i of inside[j + rows * k] is that of vertex (i, j, k) of the box.
void FindInsideRows(
  const SampleView& samples, const VertexBox& box, const void* threshold, std::uint64_t* inside);

} // namespace isosurface

#endif
