// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/InsideRows.h"

#include "Surface/Contour/BrickKernel.h"

namespace isosurface
{

void FindInsideRows(
  const SampleView& samples, const VertexBox& box, const void* threshold, std::uint64_t* inside)
{
  BrickSamples rows{};
  rows.First = samples.AtBytes(box.Low);
  const Index3 size = box.GetSize();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    rows.Stride[axis] = samples.Stride[axis];
    rows.Size[axis] = static_cast<int>(size[axis]);
  }
  GetBrickKernels().ClassifyRows(samples.Type, rows, threshold, inside);
}

} // namespace isosurface
