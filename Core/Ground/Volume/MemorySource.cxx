// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/MemorySource.h"

namespace isosurface
{

Result<SampleSlab> MemorySource::Read(const VertexBox& box)
{
  SampleSlab slab;
  slab.Arrays = this->Piece.Arrays;
  for (SampleView& view : slab.Arrays)
  {
    view.Box = box;
  }
  return slab;
}

} // namespace isosurface
