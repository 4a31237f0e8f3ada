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
#include "vtkDataSetAttributes.h"
#include "vtkExecutive.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/ChosenScalars.h"
#include "ImageSamples.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

using BlockPath = std::vector<std::int64_t>;
using ArrayFinder = std::function<Result<vtkDataArray*>(vtkImageData*)>;

/// An image of the input, or one that stands for a rectilinear grid of these lines.
struct Leaf
{
  ImagePieces::Source Source;
  std::optional<GridLines> Lines;
  BlockPath Block;
};

/// Calls visit(data, path) for the leaves of a tree of datasets, until it returns an error. The
/// partitions of a block have one path.
template <typename Visit>
Status VisitLeaves(vtkDataObject* data, BlockPath& path, const Visit& visit)
{
  const auto step = [&](std::int64_t number, vtkDataObject* child)
  {
    path.push_back(number);
    const Status status = VisitLeaves(child, path, visit);
    path.pop_back();
    return status;
  };
  if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(data))
  {
    for (unsigned int n = 0; n < blocks->GetNumberOfBlocks(); ++n)
    {
      ISOSURFACE_RETURN_IF_ERROR(step(n, blocks->GetBlock(n)));
    }
  }
  else if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(data))
  {
    for (unsigned int n = 0; n < collection->GetNumberOfPartitionedDataSets(); ++n)
    {
      ISOSURFACE_RETURN_IF_ERROR(step(n, collection->GetPartitionedDataSet(n)));
    }
  }
  else if (auto* partitions = vtkPartitionedDataSet::SafeDownCast(data))
  {
    for (unsigned int n = 0; n < partitions->GetNumberOfPartitions(); ++n)
    {
      ISOSURFACE_RETURN_IF_ERROR(VisitLeaves(partitions->GetPartitionAsDataObject(n), path, visit));
    }
  }
  else if (auto* composite = vtkCompositeDataSet::SafeDownCast(data))
  {
    const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
    for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
    {
      ISOSURFACE_RETURN_IF_ERROR(
        step(iterator->GetCurrentFlatIndex(), iterator->GetCurrentDataObject()));
    }
  }
  else if (data)
  {
    return visit(data, path);
  }
  return Status::Ok();
}

/// The names on the way to a block.
std::string FindBlockName(vtkDataObject* data, const BlockPath& path)
{
  std::string name;
  for (const std::int64_t step : path)
  {
    const auto number = static_cast<unsigned int>(step);
    vtkInformation* info = nullptr;
    if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(data))
    {
      info = blocks->HasMetaData(number) ? blocks->GetMetaData(number) : nullptr;
      data = blocks->GetBlock(number);
    }
    else if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(data))
    {
      info = collection->HasMetaData(number) ? collection->GetMetaData(number) : nullptr;
      data = collection->GetPartitionedDataSet(number);
    }
    const char* own = info ? info->Get(vtkCompositeDataSet::NAME()) : nullptr;
    name += own ? (name.empty() ? "" : "/") + std::string(own) : "";
  }
  return name;
}

Result<std::vector<Leaf>> FindImages(vtkDataObject* input)
{
  std::vector<Leaf> images;
  const auto add = [&images](vtkDataObject* data, const BlockPath& block)
  {
    auto* set = vtkDataSet::SafeDownCast(data);
    auto* lined = vtkRectilinearGrid::SafeDownCast(data);
    auto* image = vtkImageData::SafeDownCast(data);
    if (!image && !lined)
    {
      return Status(StatusCode::InvalidArgument,
        std::string("the input has a ") + data->GetClassName() +
          ", but only image data and rectilinear grids can be contoured here: take Contour, or put "
          "Resample To Image in front");
    }
    if (set->GetNumberOfPoints() == 0)
    {
      return Status::Ok();
    }
    Leaf leaf{ { image, nullptr, 0 }, {}, block };
    if (lined)
    {
      leaf.Source.Owner = MakeStructuredImage(lined);
      leaf.Source.Image = image = leaf.Source.Owner;
      leaf.Lines = MakeGridLines(lined);
      ISOSURFACE_RETURN_IF_ERROR(
        leaf.Lines->Check(MakeGridGeometry(image, image->GetExtent()).GetDimensions()));
    }
    images.push_back(std::move(leaf));
    return Status::Ok();
  };
  BlockPath path;
  ISOSURFACE_RETURN_IF_ERROR(VisitLeaves(input, path, add));
  return images;
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

Result<vtkDataArray*> TakeContouredArray(vtkInformation* inInfo, vtkImageData* image,
  vtkDataArray* array, int association, int component, CellAverages& averages, int threads)
{
  if (!array)
  {
    return array;
  }
  const std::string name = array->GetName() ? array->GetName() : "";
  if (!FindChosenComponent(array->GetNumberOfComponents(), component))
  {
    return MakeComponentError(name, array->GetNumberOfComponents(), component);
  }
  if (association == vtkDataObject::FIELD_ASSOCIATION_CELLS)
  {
    return averages.Find(image, FindImageTime(inInfo, image), array, threads);
  }
  return association == vtkDataObject::FIELD_ASSOCIATION_POINTS
    ? Result<vtkDataArray*>(array)
    : Status(StatusCode::InvalidArgument,
        "array \"" + name + "\" is neither a point array nor a cell array");
}

Status MakeMissingArrayError(vtkDataObject* input, const std::string& name)
{
  std::string text = "the input has no point array " +
    (name.empty() ? "that is active" : "\"" + name + "\"") + " to contour";
  for (vtkDataSet* data : vtkCompositeDataSet::GetDataSets<vtkDataSet>(input))
  {
    const std::string cells = ListArrays(data->GetCellData());
    if (!cells.empty())
    {
      text += "; it has the cell arrays " + cells + ", which can be chosen as such";
      break;
    }
  }
  return { StatusCode::NotFound, text };
}

Result<MemoryPiece> MakePiece(
  const GridGeometry& grid, const ImagePieces::Source& source, vtkDataArray* array)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto samples, MakeImageSamples(grid, source.Image, array));
  Fingerprint identity;
  identity.AddNumber(reinterpret_cast<std::uintptr_t>(samples.Array.Get()));
  identity.AddNumber(std::max(source.Time, samples.Array->GetMTime()));
  return MemoryPiece{ 0, std::move(samples.Components), samples.Hidden, {}, identity.Get(),
    std::make_shared<vtkSmartPointer<vtkDataArray>>(samples.Array) };
}

/// An image whose array is to be contoured. `isInput`: whether it is the input itself.
MemoryImage DescribeLeaf(
  const Leaf& leaf, vtkDataArray* array, bool isInput, vtkInformation* inputInfo)
{
  vtkImageData* image = leaf.Source.Image;
  int extent[6];
  image->GetExtent(extent);
  int whole[6];
  bool hasWhole = FindWholeExtent(image, whole);
  if (isInput && inputInfo->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
  {
    inputInfo->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
    hasWhole = true;
  }
  // What lines there are beyond the pieces is not known.
  for (int axis = 0; hasWhole && !leaf.Lines && axis < 3; ++axis)
  {
    extent[2 * axis] = std::min(extent[2 * axis], whole[2 * axis]);
    extent[2 * axis + 1] = std::max(extent[2 * axis + 1], whole[2 * axis + 1]);
  }
  return { MakeGridGeometry(image, extent), leaf.Lines, hasWhole, leaf.Block,
    [source = leaf.Source, array](const GridGeometry& grid)
    { return MakePiece(grid, source, array); } };
}

Result<MemoryImages> DescribeImages(vtkDataObject* input, vtkInformation* inputInfo,
  const ArrayFinder& findArray, std::vector<ImagePieces::Source>& sources)
{
  ISOSURFACE_ASSIGN_OR_RETURN(std::vector<Leaf> leaves, FindImages(input));
  MemoryImages images;
  images.AreThere = !leaves.empty();
  for (Leaf& leaf : leaves)
  {
    vtkImageData* image = leaf.Source.Image;
    ISOSURFACE_ASSIGN_OR_RETURN(vtkDataArray * array, findArray(image));
    if (array)
    {
      leaf.Source.Time = FindImageTime(inputInfo, image);
      images.Images.push_back(DescribeLeaf(leaf, array, image == input, inputInfo));
      sources.push_back(leaf.Source);
    }
  }
  return images;
}

// Gives a piece the arrays of these names to interpolate.
Result<std::vector<InterpolatedArray>> AddAttributesTo(MemoryPiece& piece,
  const ImagePieces::Source& source, const std::vector<std::string>& names, CellAverages& averages,
  int threads)
{
  using Owners = std::pair<std::shared_ptr<const void>, std::vector<vtkSmartPointer<vtkDataArray>>>;
  const auto owners = std::make_shared<Owners>();
  owners->first = std::exchange(piece.Owner, owners);
  std::vector<InterpolatedArray> arrays;
  for (const std::string& name : names)
  {
    vtkDataArray* array = source.Image->GetPointData()->GetArray(name.c_str());
    vtkDataArray* cells = source.Image->GetCellData()->GetArray(name.c_str());
    if (!array && cells)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(array, averages.Find(source.Image, source.Time, cells, threads));
    }
    if (!array || array->GetNumberOfTuples() != source.Image->GetNumberOfPoints())
    {
      return Status(StatusCode::NotFound,
        "the input has no numeric point array or cell array \"" + name +
          "\" to interpolate everywhere");
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const ValueType type, GetValueTypeOf(array));
    owners->second.push_back(MakePlainArray(array));
    InterpolatedArray description{ name, {}, { type, array->GetNumberOfComponents() } };
    for (int n = 0; array->HasAComponentName() && n < array->GetNumberOfComponents(); ++n)
    {
      const char* componentName = array->GetComponentName(n);
      description.ComponentNames.emplace_back(componentName ? componentName : "");
    }
    const SampleView& scalars = piece.Components.front();
    AttributeView view{ MakeComponentViews(owners->second.back(), type, scalars.Available) };
    for (SampleView& component : view.Components)
    {
      component.Box = scalars.Box;
    }
    arrays.push_back(std::move(description));
    piece.Attributes.push_back(std::move(view));
  }
  return arrays;
}

} // namespace

Result<ImagePieces> CollectContouredPieces(Communicator& ranks, vtkInformation* inInfo,
  const ArrayChooser& choose, const std::string& name, int component, CellAverages& averages,
  int threads)
{
  vtkDataObject* input = vtkDataObject::GetData(inInfo);
  const auto find = [&](vtkImageData* image)
  {
    int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
    vtkDataArray* array = choose(image, association);
    return TakeContouredArray(inInfo, image, array, association, component, averages, threads);
  };
  ImagePieces pieces;
  auto collected = CollectedGrids::Collect(
    ranks, [&] { return DescribeImages(input, inInfo, find, pieces.Sources); }, threads);
  if (collected.GetStatus().GetCode() == StatusCode::NotFound)
  {
    return MakeMissingArrayError(input, name);
  }
  ISOSURFACE_RETURN_IF_ERROR(collected.GetStatus());
  const auto nameBlocks = [&]
  {
    static_cast<CollectedGrids&>(pieces) = std::move(*collected);
    for (const BlockPath& path : pieces.Paths)
    {
      pieces.BlockNames.push_back(FindBlockName(input, path));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(Attempt("the images of the input cannot be prepared", nameBlocks));
  return pieces;
}

bool IsCellArrayChosen(vtkInformation* array, vtkInformation* inInfo)
{
  const int association = array->Get(vtkDataObject::FIELD_ASSOCIATION());
  const auto hasScalars = [inInfo](int ofWhat)
  {
    return vtkDataObject::GetActiveFieldInformation(
             inInfo, ofWhat, vtkDataSetAttributes::SCALARS) != nullptr;
  };
  return association == vtkDataObject::FIELD_ASSOCIATION_CELLS ||
    (association == vtkDataObject::FIELD_ASSOCIATION_POINTS_THEN_CELLS &&
      !hasScalars(vtkDataObject::FIELD_ASSOCIATION_POINTS) &&
      hasScalars(vtkDataObject::FIELD_ASSOCIATION_CELLS));
}

std::string FindContouredUnit(
  vtkDataObject* input, const std::function<vtkDataArray*(vtkDataSet*)>& choose)
{
  for (vtkDataSet* data : vtkCompositeDataSet::GetDataSets<vtkDataSet>(input))
  {
    vtkDataArray* array = choose(data);
    const std::string unit = array ? GetUnitOf(array) : "";
    if (!unit.empty())
    {
      return unit;
    }
    if (array && array->GetName() && std::strcmp(array->GetName(), "HU") == 0)
    {
      return "HU";
    }
  }
  return "";
}

Result<std::vector<InterpolatedArray>> AddAttributes(
  ImagePieces& pieces, const std::vector<std::string>& names, CellAverages& averages, int threads)
{
  std::vector<InterpolatedArray> all;
  for (std::size_t number = 0; number < pieces.Pieces.size(); ++number)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto arrays,
      AddAttributesTo(
        pieces.Pieces[number], pieces.Sources[pieces.Images[number]], names, averages, threads));
    if (number == 0)
    {
      all = std::move(arrays);
    }
    else if (arrays != all)
    {
      return Status(StatusCode::InvalidArgument,
        "the arrays to interpolate are not of the same types in all images of the input");
    }
  }
  return all;
}

} // namespace isosurface
