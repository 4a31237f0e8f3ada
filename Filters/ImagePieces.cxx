// SPDX-License-Identifier: BSD-3-Clause
#include "ImagePieces.h"

#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkPointData.h"
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

// The sides of a part that are closed sides of the grid.
GridSides FindClosedSides(
  const GridGeometry& part, const GridGeometry& grid, const GridSides& closedSides)
{
  GridSides closed;
  for (std::size_t side = 0; side < 6; ++side)
  {
    closed.Sides[side] = closedSides.Sides[side] && part.Extent[side] == grid.Extent[side];
  }
  return closed;
}

// From the numbers of a part of a grid to those of the grid.
void RenumberGlobalIds(const GridGeometry& part, const ContourRequest& partRequest,
  const GridGeometry& grid, const ContourRequest& request, Surface& surface)
{
  const GridGeometry fromGrid = GetNumberedGrid(part, partRequest);
  const GridGeometry toGrid = GetNumberedGrid(grid, request);
  const Index3 from = fromGrid.GetDimensions();
  const Index3 to = toGrid.GetDimensions();
  Index3 low;
  for (int axis = 0; axis < 3; ++axis)
  {
    low[axis] = fromGrid.Extent[2 * axis] - toGrid.Extent[2 * axis];
  }
  const auto findVertex = [&](std::int64_t vertex)
  {
    const std::int64_t i = low[0] + vertex % from[0];
    const std::int64_t j = low[1] + vertex / from[0] % from[1];
    const std::int64_t k = low[2] + vertex / (from[0] * from[1]);
    return i + to[0] * (j + to[1] * k);
  };
  const std::int64_t fromVertices = fromGrid.GetNumberOfVertices();
  const std::int64_t toVertices = toGrid.GetNumberOfVertices();
  const auto isovalues = static_cast<std::int64_t>(request.Isovalues.size());
  for (std::int64_t& id : surface.GlobalIds)
  {
    // Ids of edges, then ids of vertices: see ExtractSurface.
    const std::int64_t edgeIds = 3 * fromVertices * isovalues;
    if (id < edgeIds)
    {
      const std::int64_t isovalueNumber = id / (3 * fromVertices);
      const std::int64_t vertex = findVertex(id % (3 * fromVertices) / 3);
      id = 3 * (isovalueNumber * toVertices + vertex) + id % 3;
    }
    else
    {
      const std::int64_t isovalueNumber = (id - edgeIds) / fromVertices;
      const std::int64_t vertex = findVertex((id - edgeIds) % fromVertices);
      id = (3 * isovalues + isovalueNumber) * toVertices + vertex;
    }
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
    pieces.Pieces.push_back({ leaf.Image, std::move(*samples), grid });
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  return pieces;
}

Result<PieceAttributes> FindAttributes(
  const ImagePiece& piece, const std::vector<std::string>& names)
{
  PieceAttributes attributes;
  for (const std::string& name : names)
  {
    vtkDataArray* array = piece.Image->GetPointData()->GetArray(name.c_str());
    if (!array || array->GetNumberOfTuples() != piece.Image->GetNumberOfPoints())
    {
      return Status(StatusCode::NotFound,
        "the input has no numeric point array \"" + name + "\" to interpolate everywhere");
    }
    const Result<ValueType> type = GetValueTypeOf(array);
    if (!type.IsOk())
    {
      return type.GetStatus();
    }
    attributes.Owners.emplace_back(array);
    if (!array->HasStandardMemoryLayout())
    {
      attributes.Owners.back() =
        vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
      attributes.Owners.back()->DeepCopy(array);
    }
    const int components = array->GetNumberOfComponents();
    InterpolatedArray description{ name, {}, { *type, components } };
    AttributeView view;
    for (int component = 0; component < components; ++component)
    {
      if (array->HasAComponentName())
      {
        const char* componentName = array->GetComponentName(component);
        description.ComponentNames.emplace_back(componentName ? componentName : "");
      }
      SampleView samples = piece.Samples.Components.front();
      const Index3 size = samples.Available.GetSize();
      samples.Type = *type;
      samples.First = attributes.Owners.back()->GetVoidPointer(component);
      samples.Stride = { components, static_cast<std::ptrdiff_t>(components * size[0]),
        static_cast<std::ptrdiff_t>(components * size[0] * size[1]) };
      view.Components.push_back(samples);
    }
    attributes.Arrays.push_back(std::move(description));
    attributes.Views.push_back(std::move(view));
  }
  return attributes;
}

Result<Surface> ExtractPiece(const GridGeometry& grid, const SampleView& samples,
  const std::vector<AttributeView>& attributes, const BlockRanges& ranges,
  const ContourRequest& request, const Region& region, int threads, const Progress& progress)
{
  if (!request.Normals || HasLayerForGradients(grid, samples))
  {
    GridBlockSource source(
      samples, ranges, request.Isovalues, { request.ClosedSides, region }, grid);
    source.SetAttributes(attributes);
    return ExtractSurface(grid, source, request, threads, progress);
  }
  SampleView isolated = samples;
  const GridGeometry part = Isolate(grid, isolated);
  std::vector<AttributeView> isolatedAttributes = attributes;
  for (AttributeView& attribute : isolatedAttributes)
  {
    for (SampleView& component : attribute.Components)
    {
      Isolate(grid, component);
    }
  }
  ContourRequest partRequest = request;
  partRequest.ClosedSides = FindClosedSides(part, grid, request.ClosedSides);
  GridBlockSource source(
    isolated, ranges, request.Isovalues, { partRequest.ClosedSides, region }, part);
  source.SetAttributes(std::move(isolatedAttributes));
  Result<Surface> surface = ExtractSurface(part, source, partRequest, threads, progress);
  if (surface.IsOk())
  {
    RenumberGlobalIds(part, partRequest, grid, request, *surface);
  }
  return surface;
}

} // namespace isosurface
