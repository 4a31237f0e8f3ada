// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleRange_h
#define isosurface_SampleRange_h

#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"

namespace isosurface
{

/// The range of samples: of all of them, and of the finite ones.
struct SampleRange
{
  KeyRange All;
  KeyRange Finite;

  void Add(const SampleRange& other);
};

/// The range of the samples in `box`. Cost: one pass over them, two if there are infinities.
SampleRange FindSampleRange(const SampleView& samples, const VertexBox& box);

} // namespace isosurface

#endif
