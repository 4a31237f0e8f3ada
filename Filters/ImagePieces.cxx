// SPDX-License-Identifier: BSD-3-Clause
#include "ImagePieces.h"

#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Contour/GridBlockSource.h"
#include "Contour/SurfaceExtractor.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <tuple>

namespace isosurface
{
namespace
{

struct Leaf
{
  vtkImageData* Image;
  vtkDataArray* Array;
  GridGeometry Grid; ///< with the extent of this leaf alone
};

// What makes two images pieces of one grid; also the order of the grids.
auto GetFrame(const GridGeometry& grid)
{
  return std::tie(grid.Origin, grid.Spacing, grid.Direction);
}

Result<std::vector<vtkImageData*>> FindImages(vtkDataObject* input)
{
  std::vector<vtkImageData*> images;
  auto add = [&images](vtkDataObject* data)
  {
    auto* image = vtkImageData::SafeDownCast(data);
    if (data && !image)
    {
      return Status(StatusCode::InvalidArgument,
        std::string("the input has a ") + data->GetClassName() +
          "; only vtkImageData can be contoured");
    }
    if (image && image->GetNumberOfPoints() > 0)
    {
      images.push_back(image);
    }
    return Status::Ok();
  };
  if (auto* composite = vtkCompositeDataSet::SafeDownCast(input))
  {
    const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
    iterator->SkipEmptyNodesOn();
    for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
    {
      ISOSURFACE_RETURN_IF_ERROR(add(iterator->GetCurrentDataObject()));
    }
  }
  else
  {
    ISOSURFACE_RETURN_IF_ERROR(add(input));
  }
  return images;
}

Status CollectLeaves(vtkDataObject* input, vtkInformation* inputInfo,
  const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray, std::vector<Leaf>& leaves,
  std::size_t& numberOfImages)
{
  const Result<std::vector<vtkImageData*>> images = FindImages(input);
  if (!images.IsOk())
  {
    return images.GetStatus();
  }
  numberOfImages = images->size();
  for (vtkImageData* image : *images)
  {
    const Result<vtkDataArray*> array = findArray(image);
    if (!array.IsOk())
    {
      return array.GetStatus();
    }
    if (!*array)
    {
      continue;
    }
    int extent[6];
    image->GetExtent(extent);
    int whole[6];
    bool hasWhole = FindWholeExtent(image, whole);
    if (image == input && inputInfo->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    {
      inputInfo->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
      hasWhole = true;
    }
    if (hasWhole)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        extent[2 * axis] = std::min(extent[2 * axis], whole[2 * axis]);
        extent[2 * axis + 1] = std::max(extent[2 * axis + 1], whole[2 * axis + 1]);
      }
    }
    leaves.push_back({ image, *array, MakeGridGeometry(image, extent) });
  }
  return Status::Ok();
}

// The distinct grids of all ranks, in the order of their frames.
std::vector<GridGeometry> UniteGrids(Communicator& ranks, const std::vector<Leaf>& leaves)
{
  static_assert(std::is_trivially_copyable_v<GridGeometry>, "grids travel as bytes");
  Message mine(leaves.size() * sizeof(GridGeometry));
  for (std::size_t index = 0; index < leaves.size(); ++index)
  {
    std::memcpy(&mine[index * sizeof(GridGeometry)], &leaves[index].Grid, sizeof(GridGeometry));
  }
  std::vector<GridGeometry> all;
  for (const Message& message : ranks.AllGather(mine))
  {
    for (std::size_t at = 0; at + sizeof(GridGeometry) <= message.size();
         at += sizeof(GridGeometry))
    {
      all.emplace_back();
      std::memcpy(&all.back(), &message[at], sizeof(GridGeometry));
    }
  }
  std::stable_sort(all.begin(), all.end(),
    [](const GridGeometry& a, const GridGeometry& b) { return GetFrame(a) < GetFrame(b); });
  std::vector<GridGeometry> united;
  for (const GridGeometry& grid : all)
  {
    if (united.empty() || GetFrame(united.back()) != GetFrame(grid))
    {
      united.push_back(grid);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      auto& extent = united.back().Extent;
      extent[2 * axis] = std::min(extent[2 * axis], grid.Extent[2 * axis]);
      extent[2 * axis + 1] = std::max(extent[2 * axis + 1], grid.Extent[2 * axis + 1]);
    }
  }
  return united;
}

// Whether the samples reach one layer beyond Box on every side where the grid goes on.
bool HasLayerForGradients(const GridGeometry& grid, const SampleView& samples)
{
  const Index3 size = grid.GetDimensions();
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::int64_t low = std::max<std::int64_t>(samples.Box.Low[axis] - 1, 0);
    const std::int64_t high = std::min(samples.Box.High[axis] + 1, size[axis]);
    if (samples.Available.Low[axis] > low || samples.Available.High[axis] < high)
    {
      return false;
    }
  }
  return true;
}

// Counts the samples' vertices from Available's low corner, and returns the grid of Available.
GridGeometry Isolate(const GridGeometry& grid, SampleView& samples)
{
  GridGeometry part = grid;
  const Index3 low = samples.Available.Low;
  for (int axis = 0; axis < 3; ++axis)
  {
    part.Extent[2 * axis] = grid.Extent[2 * axis] + low[axis];
    part.Extent[2 * axis + 1] = grid.Extent[2 * axis] + samples.Available.High[axis] - 1;
    for (VertexBox* box : { &samples.Available, &samples.Box })
    {
      box->Low[axis] -= low[axis];
      box->High[axis] -= low[axis];
    }
  }
  return part;
}

// From the numbers of a part of a grid to those of the grid.
void RenumberGlobalIds(const GridGeometry& part, const GridGeometry& grid, Surface& surface)
{
  const Index3 from = part.GetDimensions();
  const Index3 to = grid.GetDimensions();
  Index3 low;
  for (int axis = 0; axis < 3; ++axis)
  {
    low[axis] = part.Extent[2 * axis] - grid.Extent[2 * axis];
  }
  const std::int64_t count = 3 * part.GetNumberOfVertices();
  for (std::int64_t& id : surface.GlobalIds)
  {
    const std::int64_t isovalueNumber = id / count;
    const std::int64_t axis = id % 3;
    const std::int64_t vertex = id % count / 3;
    const std::int64_t i = low[0] + vertex % from[0];
    const std::int64_t j = low[1] + vertex / from[0] % from[1];
    const std::int64_t k = low[2] + vertex / (from[0] * from[1]);
    id = 3 * (isovalueNumber * grid.GetNumberOfVertices() + i + to[0] * (j + to[1] * k)) + axis;
  }
}

} // namespace

Result<ImagePieces> CollectImagePieces(Communicator& ranks, vtkDataObject* input,
  vtkInformation* inputInfo, const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray)
{
  std::vector<Leaf> leaves;
  std::size_t numberOfImages = 0;
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(CollectLeaves(input, inputInfo, findArray, leaves, numberOfImages)));
  std::vector<std::uint64_t> counts{ numberOfImages, leaves.size() };
  ranks.ReduceSum(counts);
  if (counts[0] > 0 && counts[1] == 0)
  {
    return Status(StatusCode::NotFound, "the input has no such point array");
  }

  ImagePieces pieces;
  pieces.Grids = UniteGrids(ranks, leaves);
  Status status;
  for (const Leaf& leaf : leaves)
  {
    std::size_t grid = 0;
    while (GetFrame(pieces.Grids[grid]) != GetFrame(leaf.Grid))
    {
      ++grid;
    }
    Result<ImageSamples> samples = MakeImageSamples(pieces.Grids[grid], leaf.Image, leaf.Array);
    if (!samples.IsOk())
    {
      status = samples.GetStatus();
      break;
    }
    pieces.Pieces.push_back({ std::move(*samples), grid });
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  return pieces;
}

Result<Surface> ExtractPiece(const GridGeometry& grid, const SampleView& samples,
  const BlockRanges& ranges, const ContourRequest& request, int threads, const Progress& progress)
{
  if (!request.Normals || HasLayerForGradients(grid, samples))
  {
    GridBlockSource source(samples, ranges, request.Isovalues);
    return ExtractSurface(grid, source, request, threads, progress);
  }
  SampleView isolated = samples;
  const GridGeometry part = Isolate(grid, isolated);
  GridBlockSource source(isolated, ranges, request.Isovalues);
  Result<Surface> surface = ExtractSurface(part, source, request, threads, progress);
  if (surface.IsOk())
  {
    RenumberGlobalIds(part, grid, *surface);
  }
  return surface;
}

} // namespace isosurface
