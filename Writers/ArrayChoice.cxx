// SPDX-License-Identifier: BSD-3-Clause
#include "ArrayChoice.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkPointData.h"

#include "ImageSamples.h"

#include <map>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* Advice = "blocked volumes store point arrays; WriteCellArrays (--cells) "
                               "averages them, as does Cell Data to "
                               "Point Data";

std::map<std::string, vtkDataArray*> FindArrays(vtkDataSetAttributes* attributes)
{
  std::map<std::string, vtkDataArray*> arrays;
  for (int index = 0; index < attributes->GetNumberOfArrays(); ++index)
  {
    vtkDataArray* array = attributes->GetArray(index);
    if (array && GetNameOf(array) != vtkDataSetAttributes::GhostArrayName())
    {
      arrays.emplace(GetNameOf(array), array);
    }
  }
  return arrays;
}

void AddName(std::string& names, const std::string& name)
{
  names += (names.empty() ? "\"" : ", \"") + name + "\"";
}

Status CheckChosen(const std::string& name, const std::map<std::string, vtkDataArray*>& points,
  const std::map<std::string, vtkDataArray*>& cells)
{
  const auto array = points.find(name);
  if (array != points.end())
  {
    return GetValueTypeOf(array->second).GetStatus();
  }
  return Status(StatusCode::InvalidArgument,
    cells.count(name) != 0 ? "array \"" + name + "\" is a cell array: " + Advice
                           : "the input has no numeric point array \"" + name + "\" to write");
}

} // namespace

std::string GetNameOf(vtkDataArray* array)
{
  return array->GetName() && *array->GetName() ? array->GetName() : "scalars";
}

Result<ArrayChoice> ArrayChoice::Make(
  vtkImageData* image, vtkDataArraySelection* chosen, bool withCells)
{
  auto points = FindArrays(image->GetPointData());
  auto cells = FindArrays(image->GetCellData());
  if (withCells)
  {
    // They become point arrays.
    points.merge(cells);
    cells.clear();
  }
  ArrayChoice choice;
  if (chosen)
  {
    for (int index = 0; index < chosen->GetNumberOfArrays(); ++index)
    {
      const std::string name = chosen->GetArrayName(index);
      if (chosen->GetArraySetting(index) != 0)
      {
        ISOSURFACE_RETURN_IF_ERROR(CheckChosen(name, points, cells));
        choice.Names.insert(name);
      }
    }
    return choice.Names.empty() ? Result<ArrayChoice>(Status(StatusCode::InvalidArgument,
                                    "no point array is chosen to write"))
                                : choice;
  }
  std::string others;
  for (const auto& [name, array] : points)
  {
    if (GetValueTypeOf(array).IsOk())
    {
      choice.Names.insert(name);
    }
    else
    {
      AddName(others, name);
    }
  }
  std::string cellNames;
  for (const auto& [name, array] : cells)
  {
    AddName(cellNames, name);
  }
  if (choice.Names.empty())
  {
    return Status(StatusCode::InvalidArgument,
      cellNames.empty() ? "the input has no numeric point array to write"
                        : "the input has only cell arrays (" + cellNames + "): " + Advice);
  }
  if (!cellNames.empty())
  {
    choice.LeftOut = "cell arrays are not written (" + cellNames + "): " + Advice;
  }
  if (!others.empty())
  {
    choice.LeftOut += choice.LeftOut.empty() ? "" : "; ";
    choice.LeftOut += "point arrays that are not numeric are not written (" + others + ")";
  }
  return choice;
}

} // namespace isosurface
