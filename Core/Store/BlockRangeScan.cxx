// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockRangeScan.h"

#include "Base/ParallelFor.h"

#include <algorithm>
#include <array>
#include <future>
#include <utility>

namespace isosurface
{
namespace
{

/// More than this at once is not read faster.
constexpr std::uint64_t LargestSlabBytes = std::uint64_t{ 16 } << 20;

void Extend(KeyRange& range, const KeyRange& other)
{
  range.Minimum = std::min(range.Minimum, other.Minimum);
  range.Maximum = std::max(range.Maximum, other.Maximum);
}

/// Cuts a box into slabs of whole layers of blocks, or thinner ones where a layer is too large, or
/// rows of a slice.
void CutIntoSlabs(const SlabSource& source, const VertexBox& box, std::int64_t blockSize,
  std::uint64_t bytes, std::vector<VertexBox>& slabs)
{
  VertexBox slab = box;
  for (; slab.Low[2] < box.High[2]; slab.Low[2] = slab.High[2])
  {
    slab.High[2] = std::min(box.High[2], (slab.Low[2] / blockSize + 1) * blockSize);
    while (slab.GetSize()[2] > 1 && source.GetReadBytes(slab) > bytes)
    {
      slab.High[2] -= slab.GetSize()[2] / 2;
    }
    VertexBox rows = slab;
    for (rows.Low[1] = box.Low[1]; rows.Low[1] < box.High[1]; rows.Low[1] = rows.High[1])
    {
      rows.High[1] = box.High[1];
      while (rows.GetSize()[1] > 1 && source.GetReadBytes(rows) > bytes)
      {
        rows.High[1] -= rows.GetSize()[1] / 2;
      }
      slabs.push_back(rows);
    }
  }
}

/// The blocks on an axis that have a vertex of [low, high).
std::array<std::int64_t, 2> FindBlocks(
  const BlockGrid& grid, std::int64_t low, std::int64_t high, std::size_t axis)
{
  const std::int64_t size = grid.GetBlockSize();
  return { std::max<std::int64_t>(0, (low + size - 1) / size - 1),
    std::min(grid.GetNumberOfBlocksPerAxis()[axis], (high - 1) / size + 1) };
}

} // namespace

BlockRangeScan::BlockRangeScan(const BlockGrid& grid, std::vector<ValueType> types, int threads)
  : Grid(grid)
  , Types(std::move(types))
  , Threads(threads)
  , Ranges(Types.size(), std::vector<KeyRange>(static_cast<std::size_t>(grid.GetNumberOfBlocks())))
  , FiniteRanges(Types.size())
{
}

void BlockRangeScan::AddProfiles()
{
  this->Profiles.emplace(this->Grid, this->Types[0], this->Threads);
}

std::vector<BlockProfile> BlockRangeScan::TakeProfiles()
{
  std::vector<BlockProfile> profiles;
  if (this->Profiles)
  {
    profiles = this->Profiles->GetProfiles();
    this->Profiles.reset();
  }
  return profiles;
}

Status BlockRangeScan::Scan(SlabSource& source, const std::vector<VertexBox>& owned,
  std::uint64_t memoryBytes, const Progress& progress)
{
  std::vector<VertexBox> slabs;
  for (const VertexBox& box : owned)
  {
    CutIntoSlabs(
      source, box, this->Grid.GetBlockSize(), std::min(memoryBytes / 2, LargestSlabBytes), slabs);
  }
  const auto read = [&](std::size_t slab)
  {
    return std::async(source.CanReadAhead() ? std::launch::async : std::launch::deferred,
      [&source, box = slabs[slab]] { return source.Read(box); });
  };
  std::future<Result<SampleSlab>> next;
  for (std::size_t slab = 0; slab < slabs.size(); ++slab)
  {
    const auto samples = (slab == 0 ? read(0) : std::move(next)).get();
    if (!samples.IsOk())
    {
      return samples.GetStatus();
    }
    if (slab + 1 < slabs.size())
    {
      next = read(slab + 1);
    }
    if (!samples->Fits(this->Types, slabs[slab]))
    {
      return Status(
        StatusCode::InvalidArgument, "a rank's samples do not fit the grid or the arrays");
    }
    this->AddSlab(*samples, slabs[slab]);
    if (this->Profiles)
    {
      this->Profiles->Add(samples->Arrays[0], slabs[slab]);
    }
    if (progress && !progress(static_cast<double>(slab + 1) / static_cast<double>(slabs.size())))
    {
      return Status(StatusCode::Aborted, "stopped on request");
    }
  }
  return Status::Ok();
}

void BlockRangeScan::AddSlab(const SampleSlab& slab, const VertexBox& box)
{
  const auto x = FindBlocks(this->Grid, box.Low[0], box.High[0], 0);
  const auto y = FindBlocks(this->Grid, box.Low[1], box.High[1], 1);
  const auto z = FindBlocks(this->Grid, box.Low[2], box.High[2], 2);
  const std::int64_t rows = y[1] - y[0];
  std::vector<std::vector<SampleRange>> totals(
    static_cast<std::size_t>(this->Threads), std::vector<SampleRange>(this->Ranges.size()));
  ParallelFor(static_cast<std::size_t>(rows * (z[1] - z[0])), this->Threads,
    [&](std::size_t index, int thread)
    {
      const std::int64_t row = static_cast<std::int64_t>(index) % rows;
      const std::int64_t layer = static_cast<std::int64_t>(index) / rows;
      for (std::int64_t i = x[0]; i < x[1]; ++i)
      {
        const std::int64_t block = this->Grid.GetBlockIndex({ i, y[0] + row, z[0] + layer });
        const VertexBox part = this->Grid.GetVertices(block).Intersect(box);
        for (std::size_t array = 0; array < this->Ranges.size() && !part.IsEmpty(); ++array)
        {
          const SampleRange range = FindSampleRange(slab.Arrays[array], part);
          Extend(this->Ranges[array][static_cast<std::size_t>(block)], range.All);
          totals[static_cast<std::size_t>(thread)][array].Add(range);
        }
      }
    });
  for (const std::vector<SampleRange>& ofThread : totals)
  {
    for (std::size_t array = 0; array < ofThread.size(); ++array)
    {
      Extend(this->FiniteRanges[array], ofThread[array].Finite);
    }
  }
}

void BlockRangeScan::Reduce(Communicator& communicator)
{
  for (std::size_t array = 0; array < this->Ranges.size(); ++array)
  {
    std::vector<KeyRange>& ranges = this->Ranges[array];
    KeyRange& finite = this->FiniteRanges[array];
    std::vector<std::uint64_t> minima = { finite.Minimum };
    std::vector<std::uint64_t> maxima = { finite.Maximum };
    minima.reserve(ranges.size() + 1);
    maxima.reserve(ranges.size() + 1);
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
  if (this->Profiles)
  {
    this->Profiles->Reduce(communicator);
  }
}

} // namespace isosurface
