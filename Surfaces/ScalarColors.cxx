// SPDX-License-Identifier: BSD-3-Clause
#include "ScalarColors.h"

#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkScalarsToColors.h"
#include "vtkUnsignedCharArray.h"

#include "Surface/Drawing/DrawingBuffers.h"

namespace isosurface
{

vtkSmartPointer<vtkPolyData> MakeSurfaceOf(
  vtkDataArray* array, const std::vector<vtkIdType>& tuples)
{
  const auto some = vtkSmartPointer<vtkDataArray>::Take(array->NewInstance());
  some->SetName(array->GetName());
  some->SetLookupTable(array->GetLookupTable());
  some->SetNumberOfComponents(array->GetNumberOfComponents());
  some->SetNumberOfTuples(static_cast<vtkIdType>(tuples.size()));
  for (std::size_t n = 0; n < tuples.size(); ++n)
  {
    some->SetTuple(static_cast<vtkIdType>(n), tuples[n], array);
  }
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->GetPointData()->AddArray(some);
  return surface;
}

std::vector<std::size_t> FindRunsOf(vtkDataArray* scalars, std::size_t most)
{
  switch (scalars->GetDataType())
  {
    vtkTemplateMacro(return FindRuns(static_cast<const VTK_TT*>(scalars->GetVoidPointer(0)),
      static_cast<std::size_t>(scalars->GetNumberOfTuples()), most));
    default:
      return {}; // bits are not taken
  }
}

vtkSmartPointer<vtkUnsignedCharArray> RepeatColors(
  vtkUnsignedCharArray* colorsOfRuns, const std::vector<std::size_t>& ends)
{
  auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
  colors->SetNumberOfComponents(colorsOfRuns->GetNumberOfComponents());
  colors->SetNumberOfTuples(static_cast<vtkIdType>(ends.back()));
  std::size_t point = 0;
  for (std::size_t run = 0; run < ends.size(); ++run)
  {
    for (; point < ends[run]; ++point)
    {
      colors->SetTypedTuple(static_cast<vtkIdType>(point),
        colorsOfRuns->GetPointer(
          static_cast<vtkIdType>(run) * colorsOfRuns->GetNumberOfComponents()));
    }
  }
  return colors;
}

void WriteColorCoordinates(vtkDataArray* scalars, vtkScalarsToColors* lookupTable,
  std::size_t first, std::size_t last, float* coordinates, int threads)
{
  const int components = scalars->GetNumberOfComponents();
  const bool magnitude =
    components > 1 && lookupTable->GetVectorMode() == vtkScalarsToColors::MAGNITUDE;
  const int component = magnitude ? -1 : lookupTable->GetVectorComponent();
  TextureRange range;
  range.Minimum = lookupTable->GetRange()[0];
  range.Maximum = lookupTable->GetRange()[1];
  range.Colors = static_cast<int>(lookupTable->GetNumberOfAvailableColors());
  const std::size_t place = first * static_cast<std::size_t>(components);
  switch (scalars->GetDataType())
  {
    vtkTemplateMacro(
      FindTextureCoordinates(static_cast<const VTK_TT*>(scalars->GetVoidPointer(0)) + place,
        last - first, components, component, range, coordinates, threads));
    default:
      break; // bits are not taken
  }
}

} // namespace isosurface
