// SPDX-License-Identifier: BSD-3-Clause
#include "ContouredArray.h"

#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkInformation.h"

#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/ChosenScalars.h"
#include "ImageSamples.h"

#include <cstring>

namespace isosurface
{

namespace
{

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
  auto pieces = CollectImagePieces(ranks, input, inInfo, find, threads);
  if (!pieces.IsOk() && pieces.GetStatus().GetCode() == StatusCode::NotFound)
  {
    return MakeMissingArrayError(input, name);
  }
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

std::string FindUnit(vtkDataArray* array)
{
  const std::string unit = GetUnitOf(array);
  return unit.empty() && array->GetName() && std::strcmp(array->GetName(), "HU") == 0 ? "HU" : unit;
}

std::string FindContouredUnit(
  vtkDataObject* input, const std::function<vtkDataArray*(vtkDataSet*)>& choose)
{
  for (vtkDataSet* data : vtkCompositeDataSet::GetDataSets<vtkDataSet>(input))
  {
    vtkDataArray* array = choose(data);
    std::string unit = array ? FindUnit(array) : "";
    if (!unit.empty())
    {
      return unit;
    }
  }
  return "";
}

} // namespace isosurface
