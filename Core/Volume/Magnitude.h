// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Magnitude_h
#define isosurface_Magnitude_h

#include "Volume/SampleView.h"

#include <vector>

namespace isosurface
{

/**
 * The magnitudes of tuples: sqrt of the sum of the components' squares, each converted to double
 * and squared there, added from the first component on. Every operation is rounded to double by
 * itself, so the result is the same on all machines; it overflows to infinity where a square does,
 * and is NaN if a component is.
 *
 * components: one view each, with `box` within their Available. magnitudes: room for the box's
 * vertices, x fastest. Cost: one pass over the samples.
 */
void ComputeMagnitudes(
  const std::vector<SampleView>& components, const VertexBox& box, double* magnitudes);

/// Magnitudes of a box as samples, x fastest; Box and Available are the box.
SampleView MakeMagnitudeView(const VertexBox& box, const double* magnitudes);

} // namespace isosurface

#endif
