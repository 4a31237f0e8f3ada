// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/SpanSamples.h"

#include <algorithm>
#include <set>
#include <utility>

namespace isosurface
{
namespace
{

/// The minimum and maximum vertex on an axis that any level of a block needs.
std::pair<std::int64_t, std::int64_t> FindReach(
  const BlockGrid& grid, std::int64_t first, std::int64_t last, std::size_t axis)
{
  std::pair<std::int64_t, std::int64_t> reach = { grid.GetVertices(first).Low[axis], 0 };
  for (int level = 0; level < grid.GetNumberOfLevels(); ++level)
  {
    reach.first = std::min(reach.first, grid.GetGhostedVertices(first, level).Low[axis] << level);
    reach.second =
      std::max(reach.second, (grid.GetGhostedVertices(last, level).High[axis] - 1) << level);
  }
  return reach;
}

} // namespace

std::vector<VertexBox> SpanSamples::FindBoxes(
  const BlockGrid& grid, const BlockSpan& span, const VertexBox& part)
{
  if (span.Begin >= span.End)
  {
    return {};
  }
  const std::int64_t first = span.Begin;
  const std::int64_t last = span.End - 1;
  VertexBox rows = { { 0, 0, 0 }, grid.GetDimensions() };
  if (grid.GetBlockCoordinates(first)[2] == grid.GetBlockCoordinates(last)[2])
  {
    const auto reach = FindReach(grid, first, last, 1);
    rows.Low[1] = reach.first;
    rows.High[1] = reach.second + 1;
  }
  std::set<std::int64_t> slices;
  for (int level = 0; level < grid.GetNumberOfLevels(); ++level)
  {
    slices.insert(grid.GetGhostedVertices(first, level).Low[2] << level);
    slices.insert((grid.GetGhostedVertices(last, level).High[2] - 1) << level);
  }
  for (std::int64_t z = grid.GetVertices(first).Low[2]; z < grid.GetVertices(last).High[2]; ++z)
  {
    slices.insert(z);
  }
  std::vector<VertexBox> boxes;
  for (auto slice = slices.begin(); slice != slices.end();)
  {
    VertexBox box = rows;
    box.Low[2] = *slice;
    for (box.High[2] = *slice; slice != slices.end() && *slice == box.High[2]; ++slice)
    {
      ++box.High[2];
    }
    const VertexBox common = box.Intersect(part);
    if (!common.IsEmpty())
    {
      boxes.push_back(common);
    }
  }
  return boxes;
}

std::uint64_t SpanSamples::GetReadBytes(
  const BoxSource& source, const std::vector<VertexBox>& boxes)
{
  std::uint64_t bytes = 0;
  for (const VertexBox& box : boxes)
  {
    bytes += source.GetReadBytes(box);
  }
  return bytes;
}

Status SpanSamples::Read(BoxSource& source, const std::vector<VertexBox>& boxes,
  const std::vector<ValueType>& types,
  const std::function<void(const BoxSamples& slab, const VertexBox& box)>& whenRead)
{
  this->FirstSlice = boxes.empty() ? 0 : boxes.front().Low[2];
  for (const VertexBox& box : boxes)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto slab, source.Read(box));
    if (!slab.Fits(types, box))
    {
      return Status(
        StatusCode::InvalidArgument, "a rank's samples do not fit the grid or the arrays");
    }
    if (whenRead)
    {
      whenRead(slab, box);
    }
    const auto number = static_cast<std::uint32_t>(this->Slabs.size());
    this->Slabs.push_back(std::move(slab));
    this->SlabOfSlice.resize(static_cast<std::size_t>(box.High[2] - this->FirstSlice), number);
  }
  return Status::Ok();
}

std::vector<SampleView> SpanSamples::FindViews(const VertexBox& box) const
{
  for (const BoxSamples& slab : this->Slabs)
  {
    if (!slab.Arrays.empty() && slab.Arrays[0].Available.Intersect(box) == box)
    {
      std::vector<SampleView> views = slab.Arrays;
      for (SampleView& view : views)
      {
        view.Box = box;
      }
      return views;
    }
  }
  return {};
}

} // namespace isosurface
