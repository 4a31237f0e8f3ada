// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/MemorySource.h"

namespace isosurface
{

Result<BoxSamples> MemorySource::Read(const VertexBox& box)
{
  BoxSamples samples;
  samples.Arrays = this->Piece.Arrays;
  for (SampleView& view : samples.Arrays)
  {
    view.Box = box;
  }
  return samples;
}

} // namespace isosurface
