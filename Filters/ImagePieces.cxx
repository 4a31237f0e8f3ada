// SPDX-License-Identifier: BSD-3-Clause
#include "ImagePieces.h"

#include "PassingFilters.h"
#include "RectilinearGrids.h"

#include "vtkAlgorithm.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataSet.h"
#include "vtkExecutive.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Ground/Volume/GridUnion.h"

#include <algorithm>
#include <string>

namespace isosurface
{
namespace
{

struct Leaf
{
  vtkImageData* Image;
  vtkSmartPointer<vtkImageData> Owner; ///< if the image stands for a rectilinear grid
  vtkDataArray* Array;
  GridGeometry Grid; ///< with the extent of this leaf alone
  std::optional<GridLines> Lines;
};

Result<std::vector<Leaf>> FindImages(vtkDataObject* input)
{
  std::vector<Leaf> images;
  auto add = [&images](vtkDataObject* data)
  {
    auto* set = vtkDataSet::SafeDownCast(data);
    auto* lined = vtkRectilinearGrid::SafeDownCast(data);
    auto* image = vtkImageData::SafeDownCast(data);
    if (data && !image && !lined)
    {
      return Status(StatusCode::InvalidArgument,
        std::string("the input has a ") + data->GetClassName() +
          ", but only image data and rectilinear grids can be contoured here: take Contour, or put "
          "Resample To Image in front");
    }
    if (!set || set->GetNumberOfPoints() == 0)
    {
      return Status::Ok();
    }
    Leaf leaf{ image, nullptr, nullptr, {}, {} };
    if (lined)
    {
      leaf.Owner = MakeStructuredImage(lined);
      leaf.Image = leaf.Owner;
      leaf.Lines = MakeGridLines(lined);
      ISOSURFACE_RETURN_IF_ERROR(
        leaf.Lines->Check(MakeGridGeometry(leaf.Image, leaf.Image->GetExtent()).GetDimensions()));
    }
    images.push_back(std::move(leaf));
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
  Result<std::vector<Leaf>> images = FindImages(input);
  ISOSURFACE_RETURN_IF_ERROR(images.GetStatus());
  numberOfImages = images->size();
  for (Leaf& leaf : *images)
  {
    vtkImageData* image = leaf.Image;
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
    // What lines there are beyond the pieces is not known.
    if (hasWhole && !leaf.Lines)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        extent[2 * axis] = std::min(extent[2 * axis], whole[2 * axis]);
        extent[2 * axis + 1] = std::max(extent[2 * axis + 1], whole[2 * axis + 1]);
      }
    }
    leaf.Array = *array;
    leaf.Grid = MakeGridGeometry(image, extent);
    leaves.push_back(std::move(leaf));
  }
  return Status::Ok();
}

// The grids of leaves.
void FindLeafGrids(
  const std::vector<Leaf>& leaves, std::vector<GridGeometry>& images, std::vector<LinedGrid>& lined)
{
  for (const Leaf& leaf : leaves)
  {
    if (leaf.Lines)
    {
      lined.push_back({ leaf.Grid, *leaf.Lines });
    }
    else
    {
      images.push_back(leaf.Grid);
    }
  }
}

// The samples of leaves, in the grids of all ranks: images first. `linedNumbers`: of the leaves with
// lines, their grids.
Status AddPieces(vtkInformation* inputInfo, const std::vector<Leaf>& leaves,
  const std::vector<GridGeometry>& images, std::vector<LinedGrid> lined,
  const std::vector<std::size_t>& linedNumbers, ImagePieces& pieces)
{
  pieces.Grids = images;
  pieces.Lines.resize(images.size());
  for (LinedGrid& grid : lined)
  {
    pieces.Grids.push_back(grid.Grid);
    pieces.Lines.emplace_back(std::move(grid.Lines));
  }
  std::size_t next = 0;
  for (const Leaf& leaf : leaves)
  {
    const std::size_t grid =
      leaf.Lines ? images.size() + linedNumbers[next++] : FindGrid(pieces.Grids, leaf.Grid);
    Result<ImageSamples> samples = MakeImageSamples(pieces.Grids[grid], leaf.Image, leaf.Array);
    ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
    pieces.Pieces.push_back(
      { leaf.Image, leaf.Owner, std::move(*samples), grid, FindImageTime(inputInfo, leaf.Image) });
  }
  return Status::Ok();
}

} // namespace

vtkMTimeType ImagePiece::GetTime() const
{
  return std::max(this->ImageTime, this->Samples.Array->GetMTime());
}

vtkMTimeType FindImageTime(vtkInformation* inputInfo, vtkImageData* image)
{
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(inputInfo);
  vtkInformation* original = inputInfo;
  while (executive && FindPassedArrays(executive->GetAlgorithm()) != PassedArrays::None &&
    executive->GetNumberOfInputConnections(0) > 0)
  {
    original = executive->GetInputInformation(0, 0);
    executive = vtkExecutive::PRODUCER()->GetExecutive(original);
  }
  vtkDataObject* data = vtkDataObject::GetData(original);
  if (original == inputInfo || !data)
  {
    return image->GetMTime();
  }
  vtkMTimeType time = data->GetMTime();
  for (vtkDataSet* set : vtkCompositeDataSet::GetDataSets<vtkDataSet>(data))
  {
    time = std::max(time, set->GetMTime());
  }
  return std::min(time, image->GetMTime());
}

Result<ImagePieces> CollectImagePieces(Communicator& ranks, vtkDataObject* input,
  vtkInformation* inputInfo, const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray)
{
  std::vector<Leaf> leaves;
  std::size_t numberOfImages = 0;
  std::vector<GridGeometry> grids;
  std::vector<LinedGrid> lined;
  const std::string context = "the images of the input cannot be prepared";
  const auto collect = [&]
  {
    const Status status = CollectLeaves(input, inputInfo, findArray, leaves, numberOfImages);
    FindLeafGrids(leaves, grids, lined);
    return status;
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, context, collect));
  std::vector<std::uint64_t> counts{ numberOfImages, leaves.size() };
  ranks.ReduceSum(counts);
  if (counts[0] > 0 && counts[1] == 0)
  {
    return Status(StatusCode::NotFound, "the input has no such point array");
  }

  const auto images = UniteGrids(ranks, grids);
  ISOSURFACE_RETURN_IF_ERROR(images.GetStatus());
  std::vector<std::size_t> linedNumbers;
  auto united = UniteLinedGrids(ranks, lined, linedNumbers);
  ISOSURFACE_RETURN_IF_ERROR(united.GetStatus());
  ImagePieces pieces;
  const auto add = [&]
  { return AddPieces(inputInfo, leaves, *images, std::move(*united), linedNumbers, pieces); };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, context, add));
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
      const auto average = averages.Find(piece.Image, piece.ImageTime, cells, threads);
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
    attributes.Owners.push_back(MakePlainArray(array));
    InterpolatedArray description{ name, {}, { *type, array->GetNumberOfComponents() } };
    for (int n = 0; array->HasAComponentName() && n < array->GetNumberOfComponents(); ++n)
    {
      const char* componentName = array->GetComponentName(n);
      description.ComponentNames.emplace_back(componentName ? componentName : "");
    }
    const SampleView& scalars = piece.Samples.Components.front();
    AttributeView view{ MakeComponentViews(attributes.Owners.back(), *type, scalars.Available) };
    for (SampleView& component : view.Components)
    {
      component.Box = scalars.Box;
    }
    attributes.Arrays.push_back(std::move(description));
    attributes.Views.push_back(std::move(view));
  }
  return attributes;
}

} // namespace isosurface
