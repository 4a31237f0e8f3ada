// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/BlockSegment.h"

namespace isosurface
{
std::uint64_t BlockSegment::GetNumberOfSamples() const
{
  auto samples = static_cast<std::uint64_t>(this->Box.GetNumberOfVertices());
  if (!this->IsWhole)
  {
    std::uint64_t even = 1;
    for (int axis = 0; axis < 3; ++axis)
    {
      even *= static_cast<std::uint64_t>(
        ((this->Box.High[axis] + 1) >> 1) - ((this->Box.Low[axis] + 1) >> 1));
    }
    samples -= even;
  }
  return samples;
}

VertexBox CoarsenBox(const VertexBox& box, int level)
{
  VertexBox coarse;
  const std::int64_t round = (std::int64_t{ 1 } << level) - 1;
  for (int axis = 0; axis < 3; ++axis)
  {
    coarse.Low[axis] = (box.Low[axis] + round) >> level;
    coarse.High[axis] = (box.High[axis] + round) >> level;
  }
  return coarse;
}

} // namespace isosurface
