// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/BlockRanges.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleRange.h"
#include "Surface/Contour/BrickKernel.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace isosurface
{
namespace
{

// The minimum and maximum of a block so far.
template <typename T>
struct Extremes
{
  T Minimum = std::numeric_limits<T>::has_infinity ? std::numeric_limits<T>::infinity()
                                                   : std::numeric_limits<T>::max();
  T Maximum = std::numeric_limits<T>::has_infinity ? -std::numeric_limits<T>::infinity()
                                                   : std::numeric_limits<T>::lowest();
  bool HasNotANumber = false;

  KeyRange GetRange() const
  {
    KeyRange range;
    if (this->Minimum <= this->Maximum)
    {
      range = { MakeValueKey(this->Minimum), MakeValueKey(this->Maximum) };
    }
    if (this->HasNotANumber)
    {
      range.Minimum = NotANumberKey;
    }
    return range;
  }
};

// The ranges of a row of blocks, computed plane by plane, roughly in the order of the samples.
template <typename T>
void ComputeRowOfBlocks(const SampleView& samples, const BlockGrid& grid, std::int64_t firstBlock,
  std::vector<KeyRange>& ranges)
{
  const BrickKernels& kernels = GetBrickKernels();
  const std::int64_t count = grid.GetNumberOfBlocksPerAxis()[0];
  const VertexBox first = grid.GetVertices(firstBlock);
  std::vector<Extremes<T>> extremes(static_cast<std::size_t>(count));
  const Index3& low = samples.Box.Low;
  SampleRows rows{};
  rows.Stride[0] = samples.Stride[0];
  rows.Stride[1] = samples.Stride[1];
  rows.Size[1] = first.High[1] - first.Low[1];
  for (std::int64_t k = first.Low[2]; k < first.High[2]; ++k)
  {
    for (std::int64_t block = 0; block < count; ++block)
    {
      Extremes<T>& seen = extremes[static_cast<std::size_t>(block)];
      const std::int64_t begin = block * BlockRanges::BlockSize;
      rows.First = samples.At<T>({ low[0] + begin, low[1] + first.Low[1], low[2] + k });
      rows.Size[0] =
        std::min<std::int64_t>(BlockRanges::BlockSize + 1, grid.GetDimensions()[0] - begin);
      kernels.JoinRange(samples.Type, rows, &seen.Minimum, &seen.Maximum, &seen.HasNotANumber);
    }
  }
  for (std::int64_t block = 0; block < count; ++block)
  {
    ranges[static_cast<std::size_t>(firstBlock + block)] =
      extremes[static_cast<std::size_t>(block)].GetRange();
  }
}

} // namespace

Result<BlockRanges> BlockRanges::Compute(
  const SampleView& samples, int threads, const Progress& progress)
{
  BlockRanges made;
  made.Type = samples.Type;
  if (samples.Box.IsEmpty())
  {
    return made;
  }
  made.Grid = BlockGrid(samples.Box.GetSize(), BlockSize);
  made.Ranges.resize(static_cast<std::size_t>(made.Grid.GetNumberOfBlocks()));
  const Index3& blocks = made.Grid.GetNumberOfBlocksPerAxis();
  const bool finished = ParallelFor(
    static_cast<std::size_t>(blocks[1] * blocks[2]), threads,
    [&](std::size_t row, int)
    {
      DispatchValueType(samples.Type,
        [&](auto zero)
        {
          ComputeRowOfBlocks<decltype(zero)>(
            samples, made.Grid, static_cast<std::int64_t>(row) * blocks[0], made.Ranges);
        });
    },
    progress);
  if (!finished)
  {
    return Status(StatusCode::Aborted, "The computation of the blocks' ranges was aborted.");
  }
  return made;
}

template <typename Predicate>
std::vector<std::int64_t> BlockRanges::FindBlocks(
  const std::vector<double>& isovalues, const Predicate& isWanted) const
{
  const std::vector<ValueKey> thresholds = FindThresholdKeys(this->Type, isovalues);
  std::vector<std::int64_t> blocks;
  for (std::size_t block = 0; block < this->Ranges.size(); ++block)
  {
    const KeyRange& range = this->Ranges[block];
    if (std::any_of(thresholds.begin(), thresholds.end(),
          [&](ValueKey threshold) { return isWanted(range, threshold); }))
    {
      blocks.push_back(static_cast<std::int64_t>(block));
    }
  }
  return blocks;
}

std::vector<std::int64_t> BlockRanges::FindActiveBlocks(const std::vector<double>& isovalues) const
{
  return this->FindBlocks(isovalues,
    [](const KeyRange& range, ValueKey threshold) { return range.Straddles(threshold); });
}

std::vector<std::int64_t> BlockRanges::FindInsideBlocks(const std::vector<double>& isovalues) const
{
  return this->FindBlocks(isovalues,
    [](const KeyRange& range, ValueKey threshold)
    { return !range.IsEmpty() && threshold <= range.Minimum; });
}

} // namespace isosurface
