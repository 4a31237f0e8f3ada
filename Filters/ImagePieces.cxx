// SPDX-License-Identifier: BSD-3-Clause
#include "ImagePieces.h"

#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Volume/GridUnion.h"

#include <algorithm>
#include <string>

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
  ISOSURFACE_RETURN_IF_ERROR(images.GetStatus());
  numberOfImages = images->size();
  for (vtkImageData* image : *images)
  {
    const Result<vtkDataArray*> array = findArray(image);
    ISOSURFACE_RETURN_IF_ERROR(array.GetStatus());
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
  std::vector<GridGeometry> grids;
  for (const Leaf& leaf : leaves)
  {
    grids.push_back(leaf.Grid);
  }
  pieces.Grids = UniteGrids(ranks, grids);
  Status status;
  for (const Leaf& leaf : leaves)
  {
    const std::size_t grid = FindGrid(pieces.Grids, leaf.Grid);
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

Result<PieceAttributes> FindAttributes(const ImagePiece& piece,
  const std::vector<std::string>& names, CellAverages& averages, int threads)
{
  PieceAttributes attributes;
  for (const std::string& name : names)
  {
    vtkDataArray* array = piece.Image->GetPointData()->GetArray(name.c_str());
    vtkDataArray* cells = piece.Image->GetCellData()->GetArray(name.c_str());
    if (!array && cells)
    {
      const auto average = averages.Find(piece.Image, cells, threads);
      ISOSURFACE_RETURN_IF_ERROR(average.GetStatus());
      array = *average;
    }
    if (!array || array->GetNumberOfTuples() != piece.Image->GetNumberOfPoints())
    {
      return Status(StatusCode::NotFound,
        "the input has no numeric point array or cell array \"" + name +
          "\" to interpolate everywhere");
    }
    const Result<ValueType> type = GetValueTypeOf(array);
    ISOSURFACE_RETURN_IF_ERROR(type.GetStatus());
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

} // namespace isosurface
