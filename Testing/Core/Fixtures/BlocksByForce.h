// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_BlocksByForce_h
#define isosurface_Testing_BlocksByForce_h

#include "Fixtures/SampleVolume.h"
#include "Ground/Volume/BlockGrid.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// The oracle: the numbers of the active blocks of a grid, found by looking at all samples. With
/// all sides closed, also those at a side that have a sample inside.
template <typename T>
std::vector<std::int64_t> FindBlocksByForce(const SampleVolume<T>& volume, const BlockGrid& grid,
  const std::vector<double>& isovalues, bool closed = false)
{
  const Index3 size = volume.GetDimensions();
  std::vector<std::int64_t> blocks;
  for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
  {
    const VertexBox box = grid.GetVertices(block);
    const bool atBorder = box.Low[0] == 0 || box.Low[1] == 0 || box.Low[2] == 0 ||
      box.High[0] == size[0] || box.High[1] == size[1] || box.High[2] == size[2];
    bool isWanted = false;
    for (const double isovalue : isovalues)
    {
      bool inside = false;
      bool outside = closed && atBorder;
      VisitVertices(box,
        [&](const Index3& vertex)
        { (static_cast<double>(volume.At(vertex)) >= isovalue ? inside : outside) = true; });
      isWanted = isWanted || (inside && outside);
    }
    if (isWanted)
    {
      blocks.push_back(block);
    }
  }
  return blocks;
}

} // namespace isosurface

#endif
