// SPDX-License-Identifier: BSD-3-Clause
#include "ImagePieces.h"

#include "PassingFilters.h"
#include "RectilinearGrids.h"

#include "vtkAlgorithm.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataObjectTreeIterator.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkExecutive.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkPartitionedDataSet.h"
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
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

using BlockPath = std::vector<std::int64_t>;
using ArrayFinder = std::function<Result<vtkDataArray*>(vtkImageData*)>;

/// The array that a filter is to contour of a dataset, or null. VTK gives it to the filter alone.
struct ChosenArray : vtkAlgorithm
{
  static vtkDataArray* Find(vtkAlgorithm& filter, vtkDataObject* data, int& association)
  {
    using Getter = vtkDataArray* (vtkAlgorithm::*)(int, vtkDataObject*, int&);
    return (filter.*static_cast<Getter>(&ChosenArray::GetInputArrayToProcess))(
      0, data, association);
  }
};

/// A dataset in a composite one.
struct Child
{
  std::int64_t Number; ///< among the blocks there; -1: of the block itself, as its partitions
  vtkDataObject* Data;
  vtkInformation* Info;
};

/// None of a dataset that is no composite.
std::vector<Child> FindChildren(vtkDataObject* data)
{
  std::vector<Child> children;
  auto* composite = vtkCompositeDataSet::SafeDownCast(data);
  if (!composite)
  {
    return children;
  }
  const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
  auto* tree = vtkDataObjectTreeIterator::SafeDownCast(iterator);
  if (tree)
  {
    tree->VisitOnlyLeavesOff();
    tree->TraverseSubTreeOff();
    tree->SkipEmptyNodesOff();
  }
  const bool arePartitions = vtkPartitionedDataSet::SafeDownCast(data) != nullptr;
  for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
  {
    const auto place =
      static_cast<std::int64_t>(tree ? children.size() : iterator->GetCurrentFlatIndex());
    children.push_back({ arePartitions ? -1 : place, iterator->GetCurrentDataObject(),
      iterator->HasCurrentMetaData() ? iterator->GetCurrentMetaData() : nullptr });
  }
  return children;
}

/// Calls visit(data, path) for the leaves of a tree of datasets, until it returns an error. The
/// partitions of a block have one path.
template <typename Visit>
Status VisitLeaves(vtkDataObject* data, const BlockPath& path, const Visit& visit)
{
  if (data && !vtkCompositeDataSet::SafeDownCast(data))
  {
    return visit(data, path);
  }
  for (const Child& child : FindChildren(data))
  {
    BlockPath further = path;
    if (child.Number >= 0)
    {
      further.push_back(child.Number);
    }
    ISOSURFACE_RETURN_IF_ERROR(VisitLeaves(child.Data, further, visit));
  }
  return Status::Ok();
}

/// The names on the way to a block.
std::string FindBlockName(vtkDataObject* data, const BlockPath& path)
{
  std::string name;
  for (const std::int64_t step : path)
  {
    const std::vector<Child> children = FindChildren(data);
    const auto child = std::find_if(
      children.begin(), children.end(), [step](const Child& one) { return one.Number == step; });
    if (child == children.end())
    {
      break;
    }
    const char* own = child->Info ? child->Info->Get(vtkCompositeDataSet::NAME()) : nullptr;
    name += own ? (name.empty() ? "" : "/") + std::string(own) : "";
    data = child->Data;
  }
  return name;
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

/// The images of this rank whose array is to be contoured.
Result<MemoryImages> DescribeImages(
  vtkInformation* inInfo, const ArrayFinder& findArray, std::vector<ImagePieces::Source>& sources)
{
  using Keys = vtkStreamingDemandDrivenPipeline;
  vtkDataObject* input = vtkDataObject::GetData(inInfo);
  MemoryImages images;
  const auto add = [&](vtkDataObject* data, const BlockPath& block) -> Status
  {
    auto* lined = vtkRectilinearGrid::SafeDownCast(data);
    ImagePieces::Source source{ vtkImageData::SafeDownCast(data), nullptr, 0 };
    if (!source.Image && !lined)
    {
      return { StatusCode::InvalidArgument,
        std::string("the input has a ") + data->GetClassName() +
          ", but only image data and rectilinear grids can be contoured here: take Contour, or put "
          "Resample To Image in front" };
    }
    if (vtkDataSet::SafeDownCast(data)->GetNumberOfPoints() == 0)
    {
      return Status::Ok();
    }
    images.AreThere = true;
    MemoryImage image{ {}, {}, false, block, {} };
    if (lined)
    {
      source.Owner = MakeStructuredImage(lined);
      source.Image = source.Owner;
      image.Lines = MakeGridLines(lined);
    }
    image.Grid = MakeGridGeometry(source.Image, source.Image->GetExtent());
    if (image.Lines)
    {
      ISOSURFACE_RETURN_IF_ERROR(image.Lines->Check(image.Grid.GetDimensions()));
    }
    int whole[6];
    bool hasWhole = FindWholeExtent(source.Image, whole);
    if (source.Image == input && inInfo->Has(Keys::WHOLE_EXTENT()))
    {
      inInfo->Get(Keys::WHOLE_EXTENT(), whole);
      hasWhole = true;
    }
    if (hasWhole)
    {
      image.Declare(whole);
    }
    ISOSURFACE_ASSIGN_OR_RETURN(vtkDataArray * array, findArray(source.Image));
    if (array)
    {
      source.Time = FindImageTime(inInfo, source.Image);
      image.MakePiece = [source, array](const GridGeometry& grid) -> Result<MemoryPiece>
      {
        ISOSURFACE_ASSIGN_OR_RETURN(auto samples, MakeImageSamples(grid, source.Image, array));
        Fingerprint identity;
        identity.AddNumber(reinterpret_cast<std::uintptr_t>(samples.Array.Get()));
        identity.AddNumber(std::max(source.Time, samples.Array->GetMTime()));
        return MemoryPiece{ 0, std::move(samples.Components), samples.Hidden, {}, identity.Get(),
          std::make_shared<vtkSmartPointer<vtkDataArray>>(samples.Array) };
      };
      images.Images.push_back(std::move(image));
      sources.push_back(source);
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(VisitLeaves(input, {}, add));
  return images;
}

} // namespace

Result<ImagePieces> CollectContouredPieces(Communicator& ranks, vtkAlgorithm& filter,
  vtkInformation* inInfo, int component, CellAverages& averages, int threads)
{
  vtkDataObject* input = vtkDataObject::GetData(inInfo);
  ImagePieces pieces;
  const auto find = [&](vtkImageData* image) -> Result<vtkDataArray*>
  {
    int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
    vtkDataArray* array = ChosenArray::Find(filter, image, association);
    if (!array)
    {
      return array;
    }
    const std::string name = array->GetName() ? array->GetName() : "";
    pieces.ArrayName = name.empty() ? pieces.ArrayName : name;
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
  };
  auto collected = CollectedGrids::Collect(
    ranks, [&] { return DescribeImages(inInfo, find, pieces.Sources); }, threads);
  if (collected.GetStatus().GetCode() == StatusCode::NotFound)
  {
    return MakeMissingArrayError(input, FindContouredName(filter));
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

std::string FindContouredName(vtkAlgorithm& filter)
{
  vtkInformation* array = filter.GetInputArrayInformation(0);
  return array->Has(vtkDataObject::FIELD_NAME()) ? array->Get(vtkDataObject::FIELD_NAME()) : "";
}

bool IsCellArrayChosen(vtkAlgorithm& filter, vtkInformation* inInfo)
{
  const int association =
    filter.GetInputArrayInformation(0)->Get(vtkDataObject::FIELD_ASSOCIATION());
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

std::string FindContouredUnit(vtkAlgorithm& filter)
{
  vtkDataObject* input =
    filter.GetNumberOfInputConnections(0) > 0 ? filter.GetInputDataObject(0, 0) : nullptr;
  for (vtkDataSet* data : vtkCompositeDataSet::GetDataSets<vtkDataSet>(input))
  {
    int association = 0;
    vtkDataArray* array = ChosenArray::Find(filter, data, association);
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
  using Owners = std::pair<std::shared_ptr<const void>, std::vector<vtkSmartPointer<vtkDataArray>>>;
  std::vector<InterpolatedArray> all;
  for (std::size_t number = 0; number < pieces.Pieces.size(); ++number)
  {
    MemoryPiece& piece = pieces.Pieces[number];
    const ImagePieces::Source& source = pieces.Sources[pieces.Images[number]];
    const auto owners = std::make_shared<Owners>();
    owners->first = std::exchange(piece.Owner, owners);
    std::vector<InterpolatedArray> arrays;
    for (const std::string& name : names)
    {
      vtkDataArray* array = source.Image->GetPointData()->GetArray(name.c_str());
      vtkDataArray* cells = source.Image->GetCellData()->GetArray(name.c_str());
      if (!array && cells)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(
          array, averages.Find(source.Image, source.Time, cells, threads));
      }
      if (!array || array->GetNumberOfTuples() != source.Image->GetNumberOfPoints())
      {
        return Status(StatusCode::NotFound,
          "the input has no numeric point array or cell array \"" + name +
            "\" to interpolate everywhere");
      }
      ISOSURFACE_ASSIGN_OR_RETURN(const ValueType type, GetValueTypeOf(array));
      owners->second.push_back(MakePlainArray(array));
      piece.AddAttribute(
        { MakeComponentViews(owners->second.back(), type, piece.Components.front().Available) });
      arrays.push_back({ name, {}, { type, array->GetNumberOfComponents() } });
      for (int n = 0; array->HasAComponentName() && n < array->GetNumberOfComponents(); ++n)
      {
        const char* component = array->GetComponentName(n);
        arrays.back().ComponentNames.emplace_back(component ? component : "");
      }
    }
    if (number > 0 && arrays != all)
    {
      return Status(StatusCode::InvalidArgument,
        "the arrays to interpolate are not of the same types in all images of the input");
    }
    all = number == 0 ? std::move(arrays) : all;
  }
  return all;
}

} // namespace isosurface
