// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Magnitude_h
#define isosurface_Magnitude_h

#include "Ground/Volume/SampleView.h"

#include <vector>

namespace isosurface
{

/**
 * Computes the magnitudes of tuples in double: the components are converted, squared and added from
 * the first one on; then the square root is taken. Every operation is rounded to double, so the
 * result is the same on all machines. It is infinite if a square overflows, and NaN if a component
 * is NaN.
 *
 * components: one view each, with `box` within their Available. magnitudes: room for the box's
 * vertices, x fastest. Cost: one pass over the samples.
 */
void ComputeMagnitudes(
  const std::vector<SampleView>& components, const VertexBox& box, double* magnitudes);

/// A view of the magnitudes of a box, x fastest. Its Box and Available are the box.
SampleView MakeMagnitudeView(const VertexBox& box, const double* magnitudes);

} // namespace isosurface

#endif
