// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleRange_h
#define isosurface_SampleRange_h

#include "Volume/SampleView.h"
#include "Volume/ValueKey.h"

namespace isosurface
{

/// The range of some samples: of all of them, and without NaN and infinities.
struct SampleRange
{
  KeyRange All;
  KeyRange Finite;

  void Add(const SampleRange& other);
};

/// Reads the samples of `box` once.
SampleRange FindSampleRange(const SampleView& samples, const VertexBox& box);

} // namespace isosurface

#endif
