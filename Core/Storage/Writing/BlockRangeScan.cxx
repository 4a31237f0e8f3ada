// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockRangeScan.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/Magnitude.h"
#include "Ground/Volume/SampleRange.h"

#include <algorithm>
#include <array>
#include <future>
#include <utility>

namespace isosurface
{
namespace
{

/// What a slab may take.
struct SlabLimit
{
  /// Larger reads are not faster. But a source that decodes much for any slab does so for each.
  bool Allows(const VertexBox& box) const
  {
    constexpr std::uint64_t enough = std::uint64_t{ 8 } << 20;
    const std::uint64_t samples =
      static_cast<std::uint64_t>(box.GetNumberOfVertices()) * this->VertexBytes;
    return std::min(samples, this->Source.GetReadBytes(box)) <= enough &&
      this->Source.GetReadBytes(box) <= this->Memory;
  }

  const BoxSource& Source;
  std::uint64_t VertexBytes; ///< of the samples at a vertex
  std::uint64_t Memory;
};

/// The part [begin, end) of a box on an axis.
VertexBox Cut(const VertexBox& box, std::size_t axis, std::int64_t begin, std::int64_t end)
{
  VertexBox part = box;
  part.Low[axis] = begin;
  part.High[axis] = end;
  return part;
}

/// The maximum thickness on an axis, at least 1, with which a box is cut into nearly equal slabs.
std::int64_t FindThickness(const SlabLimit& limit, const VertexBox& box, std::size_t axis)
{
  const std::int64_t size = box.GetSize()[axis];
  std::int64_t thickness = size;
  for (std::int64_t parts = 2;
       thickness > 1 && !limit.Allows(Cut(box, axis, box.Low[axis], box.Low[axis] + thickness));
       ++parts)
  {
    thickness = (size + parts - 1) / parts;
  }
  return thickness;
}

/// Cuts a box, or a part of its rows, into slabs of whole layers of blocks, or thinner ones where a
/// layer is too large, or rows of a slice. Most have equal sizes, so that memory is reused.
void CutRowsIntoSlabs(const SlabLimit& limit, const VertexBox& box, std::int64_t blockSize,
  std::vector<VertexBox>& slabs)
{
  for (std::int64_t layer = box.Low[2]; layer < box.High[2];)
  {
    const std::int64_t end = std::min(box.High[2], (layer / blockSize + 1) * blockSize);
    const std::int64_t slices = FindThickness(limit, Cut(box, 2, layer, end), 2);
    for (; layer < end; layer += slices)
    {
      const VertexBox slab = Cut(box, 2, layer, std::min(end, layer + slices));
      const std::int64_t rows = FindThickness(limit, slab, 1);
      for (std::int64_t row = box.Low[1]; row < box.High[1]; row += rows)
      {
        slabs.push_back(Cut(slab, 1, row, std::min(box.High[1], row + rows)));
      }
    }
    layer = end;
  }
}

/// Cuts a box into slabs. Those of the rows that the source reads best together come first.
void CutIntoSlabs(const SlabLimit& limit, const VertexBox& box, std::int64_t blockSize,
  std::vector<VertexBox>& slabs)
{
  const std::int64_t rows = std::max<std::int64_t>(1, limit.Source.GetRowsAtOnce());
  for (std::int64_t row = box.Low[1]; row < box.High[1];)
  {
    const std::int64_t left = rows - row % rows;
    const std::int64_t end = left < box.High[1] - row ? row + left : box.High[1];
    CutRowsIntoSlabs(limit, Cut(box, 1, row, end), blockSize, slabs);
    row = end;
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

BlockRangeScan::BlockRangeScan(const BlockGrid& grid, ArrayVariables variables, int threads)
  : Grid(grid)
  , Variables(std::move(variables))
  , Threads(threads)
  , Ranges(static_cast<std::size_t>(grid.GetNumberOfBlocks()))
{
}

void BlockRangeScan::AddProfiles()
{
  const std::size_t variable = *this->Variables.Find(0, Variable::Magnitude);
  this->Profiles.emplace(this->Grid, this->Variables[variable].Type, this->Threads);
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

Status BlockRangeScan::Scan(BoxSource& source, const std::vector<VertexBox>& owned,
  std::uint64_t memoryBytes, const Progress& progress)
{
  const SlabLimit limit{ source, SumValueSizes(this->Variables.GetStoredTypes()), memoryBytes / 2 };
  std::vector<VertexBox> slabs;
  for (const VertexBox& box : owned)
  {
    CutIntoSlabs(limit, box, this->Grid.GetBlockSize(), slabs);
  }
  const auto read = [&](std::size_t slab)
  {
    return std::async(source.CanReadAhead() ? std::launch::async : std::launch::deferred,
      [&source, box = slabs[slab], token = ReadingStop::Share()]
      {
        const ReadingStop stop(token);
        return source.Read(box);
      });
  };
  std::future<Result<BoxSamples>> next;
  if (!slabs.empty())
  {
    next = read(0);
  }
  for (std::size_t slab = 0; slab < slabs.size(); ++slab)
  {
    ReadingStop::WaitFor(next);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, next.get());
    if (slab + 1 < slabs.size())
    {
      next = read(slab + 1);
    }
    if (!samples.Fits(this->Variables.GetStoredTypes(), slabs[slab]))
    {
      return Status(
        StatusCode::InvalidArgument, "a rank's samples do not fit the grid or the arrays");
    }
    this->AddSlab(samples, slabs[slab]);
    if (this->Profiles)
    {
      this->AddToProfiles(samples, slabs[slab]);
    }
    if (progress && !progress(static_cast<double>(slab + 1) / static_cast<double>(slabs.size())))
    {
      return Status(StatusCode::Aborted, "writing was aborted");
    }
  }
  return Status::Ok();
}

KeyRange BlockRangeScan::FindRange(const BoxSamples& slab, const VertexBox& part) const
{
  const int count = this->Variables.GetComponents(0);
  if (count == 1)
  {
    return FindSampleRange(slab.Arrays[0], part).All;
  }
  const std::vector<SampleView> components(slab.Arrays.begin(), slab.Arrays.begin() + count);
  std::vector<double> magnitudes(static_cast<std::size_t>(part.GetNumberOfVertices()));
  ComputeMagnitudes(components, part, magnitudes.data());
  return FindSampleRange(MakeMagnitudeView(part, magnitudes.data()), part).All;
}

void BlockRangeScan::AddToProfiles(const BoxSamples& slab, const VertexBox& box)
{
  const int components = this->Variables.GetComponents(0);
  if (components == 1)
  {
    this->Profiles->Add(slab.Arrays[0], box);
    return;
  }
  const std::vector<SampleView> tuple(slab.Arrays.begin(), slab.Arrays.begin() + components);
  // One layer of cubes at a time, since magnitudes may take much more memory than components.
  std::vector<double> magnitudes;
  for (std::int64_t begin = box.Low[2]; begin < box.High[2];)
  {
    const std::int64_t end =
      std::min(box.High[2], (begin / BlockProfile::CubeSize + 1) * BlockProfile::CubeSize);
    const VertexBox layer = Cut(box, 2, begin, end);
    magnitudes.resize(static_cast<std::size_t>(layer.GetNumberOfVertices()));
    ComputeMagnitudes(tuple, layer, magnitudes.data());
    this->Profiles->Add(MakeMagnitudeView(layer, magnitudes.data()), layer);
    begin = end;
  }
}

void BlockRangeScan::AddSlab(const BoxSamples& slab, const VertexBox& box)
{
  const auto x = FindBlocks(this->Grid, box.Low[0], box.High[0], 0);
  const auto y = FindBlocks(this->Grid, box.Low[1], box.High[1], 1);
  const auto z = FindBlocks(this->Grid, box.Low[2], box.High[2], 2);
  const std::int64_t rows = y[1] - y[0];
  ParallelFor(static_cast<std::size_t>(rows * (z[1] - z[0])), this->Threads,
    [&](std::size_t index, int)
    {
      const std::int64_t row = static_cast<std::int64_t>(index) % rows;
      const std::int64_t layer = static_cast<std::int64_t>(index) / rows;
      for (std::int64_t i = x[0]; i < x[1]; ++i)
      {
        const std::int64_t block = this->Grid.GetBlockIndex({ i, y[0] + row, z[0] + layer });
        const VertexBox part = this->Grid.GetVertices(block).Intersect(box);
        if (!part.IsEmpty())
        {
          this->Ranges[static_cast<std::size_t>(block)].Add(this->FindRange(slab, part));
        }
      }
    });
}

Status BlockRangeScan::Reduce(Communicator& communicator, const std::string& path)
{
  CommonRanges common;
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(communicator, path,
    [&]
    {
      for (KeyRange& range : this->Ranges)
      {
        common.Add(range);
      }
      return Status::Ok();
    }));
  common.Join(communicator);
  return this->Profiles ? this->Profiles->Reduce(communicator, path) : Status::Ok();
}

} // namespace isosurface
