// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockRangeScan.h"

#include "Base/ParallelFor.h"
#include "Store/SampleRange.h"

namespace isosurface
{

bool BlockRangeScan::Scan(const BlockGrid& grid, const VolumePiece& piece,
  const std::vector<VertexBox>& owned, std::size_t arrays, int threads, const Progress& progress)
{
  const auto blocks = static_cast<std::size_t>(grid.GetNumberOfBlocks());
  this->Ranges.assign(arrays, std::vector<KeyRange>(blocks));
  this->FiniteRanges.clear();
  std::vector<std::vector<SampleRange>> totals(
    static_cast<std::size_t>(threads), std::vector<SampleRange>(arrays));
  const auto scanBlock = [&](std::size_t block, int thread)
  {
    const VertexBox vertices = grid.GetVertices(static_cast<std::int64_t>(block));
    for (std::size_t array = 0; array < arrays; ++array)
    {
      SampleRange sum;
      for (const VertexBox& box : owned)
      {
        const VertexBox part = vertices.Intersect(box);
        if (!part.IsEmpty())
        {
          sum.Add(FindSampleRange(piece.Arrays[array], part));
        }
      }
      this->Ranges[array][block] = sum.All;
      totals[static_cast<std::size_t>(thread)][array].Add(sum);
    }
  };
  const bool isDone = ParallelFor(blocks, threads, scanBlock, progress);
  for (std::size_t array = 0; array < arrays; ++array)
  {
    SampleRange total;
    for (const std::vector<SampleRange>& ofThread : totals)
    {
      total.Add(ofThread[array]);
    }
    this->FiniteRanges.push_back(total.Finite);
  }
  return isDone;
}

void BlockRangeScan::Reduce(Communicator& communicator)
{
  for (std::size_t array = 0; array < this->Ranges.size(); ++array)
  {
    std::vector<KeyRange>& ranges = this->Ranges[array];
    KeyRange& finite = this->FiniteRanges[array];
    std::vector<std::uint64_t> minima = { finite.Minimum };
    std::vector<std::uint64_t> maxima = { finite.Maximum };
    for (const KeyRange& range : ranges)
    {
      minima.push_back(range.Minimum);
      maxima.push_back(range.Maximum);
    }
    communicator.ReduceMinimum(minima);
    communicator.ReduceMaximum(maxima);
    finite = { minima[0], maxima[0] };
    for (std::size_t block = 0; block < ranges.size(); ++block)
    {
      ranges[block] = { minima[block + 1], maxima[block + 1] };
    }
  }
}

} // namespace isosurface
