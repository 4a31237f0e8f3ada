// SPDX-License-Identifier: BSD-3-Clause
#include "SurfacePolyData.h"

#include "vtkCellArray.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkTypeInt32Array.h"
#include "vtkTypeInt64Array.h"

#include "ImageSamples.h"
#include "RangedArray.h"

#include <algorithm>
#include <type_traits>

namespace isosurface
{
namespace
{

/// Gives a buffer's memory to a VTK array.
template <typename ArrayT, typename T>
void Adopt(ArrayT* array, Buffer<T>& buffer)
{
  static_assert(std::is_same_v<typename ArrayT::ValueType, T> ||
      (std::is_integral_v<T> && sizeof(typename ArrayT::ValueType) == sizeof(T)),
    "the memory must have the array's type");
  const auto size = static_cast<vtkIdType>(buffer.GetSize());
  AdoptMemory(array, buffer.Release(), size);
}

template <typename ArrayT, typename T>
void SetCoordinates(Buffer<T>& buffer, vtkPoints* points)
{
  vtkNew<ArrayT> coordinates;
  coordinates->SetNumberOfComponents(3);
  Adopt(coordinates.Get(), buffer);
  points->SetData(coordinates);
}

void FillCells(Surface& surface, vtkPolyData* output)
{
  vtkNew<vtkCellArray> cells;
  if (surface.Connectivity.Is64Bit)
  {
    vtkNew<vtkTypeInt64Array> offsets;
    vtkNew<vtkTypeInt64Array> connectivity;
    Adopt(offsets.Get(), surface.Offsets.Values64);
    Adopt(connectivity.Get(), surface.Connectivity.Values64);
    cells->SetData(offsets, connectivity);
  }
  else
  {
    vtkNew<vtkTypeInt32Array> offsets;
    vtkNew<vtkTypeInt32Array> connectivity;
    Adopt(offsets.Get(), surface.Offsets.Values32);
    Adopt(connectivity.Get(), surface.Connectivity.Values32);
    cells->SetData(offsets, connectivity);
  }
  output->SetPolys(cells);
}

/// An array that StoreRanges can give its ranges.
template <typename ArrayT>
vtkSmartPointer<ArrayT> MakeArray(const char* name)
{
  const vtkNew<ArrayT> plain; // tells the type: vtkIdType has one of its own
  const vtkSmartPointer<vtkDataArray> array = MakeRangedArray(plain->GetDataType());
  array->SetName(name);
  return ArrayT::FastDownCast(array);
}

template <typename ArrayT>
void FillScalars(const Surface& surface, const std::string& name, vtkPolyData* output)
{
  const auto scalars = MakeArray<ArrayT>(name.c_str());
  AllocateTuples(scalars, static_cast<vtkIdType>(surface.NumberOfPoints));
  for (const SurfacePart& part : surface.Parts)
  {
    auto* first = scalars->GetPointer(0) + part.FirstPoint;
    std::fill(
      first, first + part.NumberOfPoints, static_cast<typename ArrayT::ValueType>(part.Isovalue));
  }
  output->GetPointData()->SetScalars(scalars);
}

void FillAttribute(
  SurfaceAttribute& attribute, const InterpolatedArray& description, vtkPolyData* output)
{
  const vtkSmartPointer<vtkDataArray> array = MakeRangedArray(GetVTKType(attribute.Layout.Type));
  array->SetName(description.Name.c_str());
  array->SetNumberOfComponents(attribute.Layout.NumberOfComponents);
  for (std::size_t component = 0; component < description.ComponentNames.size(); ++component)
  {
    array->SetComponentName(
      static_cast<vtkIdType>(component), description.ComponentNames[component].c_str());
  }
  const std::size_t values = attribute.Bytes.GetSize() / GetValueSize(attribute.Layout.Type);
  AdoptMemory(array, attribute.Bytes.Release(), static_cast<vtkIdType>(values));
  output->GetPointData()->AddArray(array);
}

} // namespace

void MoveToPolyData(Surface& surface, const std::vector<InterpolatedArray>& arrays,
  const std::string& scalarsName, vtkPolyData* output)
{
  const bool normals = !surface.Normals.IsEmpty();
  vtkNew<vtkPoints> points;
  if (surface.HasDoublePoints)
  {
    SetCoordinates<vtkDoubleArray>(surface.DoublePoints, points);
  }
  else
  {
    SetCoordinates<vtkFloatArray>(surface.Points, points);
  }
  output->SetPoints(points);
  if (surface.NumberOfCells > 0)
  {
    FillCells(surface, output);
  }
  for (std::size_t n = 0; n < surface.Attributes.size(); ++n)
  {
    FillAttribute(surface.Attributes[n], arrays[n], output);
  }
  if (normals)
  {
    const auto array = MakeArray<vtkFloatArray>("Normals");
    array->SetNumberOfComponents(3);
    Adopt(array.Get(), surface.Normals);
    output->GetPointData()->SetNormals(array);
  }
  if (!scalarsName.empty())
  {
    const bool exact = std::all_of(surface.Parts.begin(), surface.Parts.end(),
      [](const SurfacePart& part)
      { return static_cast<double>(static_cast<float>(part.Isovalue)) == part.Isovalue; });
    if (exact)
    {
      FillScalars<vtkFloatArray>(surface, scalarsName, output);
    }
    else
    {
      FillScalars<vtkDoubleArray>(surface, scalarsName, output);
    }
  }
  // The last array: vtkAdaptiveSubdivisionFilter, which drops it, mixes up those behind it.
  const auto ids = MakeArray<vtkIdTypeArray>("GlobalIds");
  Adopt(ids.Get(), surface.GlobalIds);
  output->GetPointData()->SetGlobalIds(ids);
}

} // namespace isosurface
