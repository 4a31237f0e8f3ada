// SPDX-License-Identifier: BSD-3-Clause
#include "ArrayRanges.h"

#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleVectorKey.h"
#include "vtkInformationInformationVectorKey.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include "Surface/Contour/TupleRanges.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace isosurface
{
namespace
{

template <typename T>
void StoreComponents(vtkDataArray* array, const std::vector<ValueSpan<T>>& spans)
{
  for (vtkInformationInformationVectorKey* key :
    { vtkDataArray::PER_COMPONENT(), vtkDataArray::PER_FINITE_COMPONENT() })
  {
    vtkNew<vtkInformationVector> components;
    for (const ValueSpan<T>& span : spans)
    {
      const double range[2] = { static_cast<double>(span.Minimum),
        static_cast<double>(span.Maximum) };
      vtkNew<vtkInformation> component;
      component->Set(vtkDataArray::COMPONENT_RANGE(), range, 2);
      components->Append(component);
    }
    array->GetInformation()->Set(key, components);
  }
}

template <typename T>
void Store(vtkDataArray* array, const TupleRanges<T>& ranges)
{
  StoreComponents(array, ranges.Components);
  if (ranges.Components.size() > 1)
  {
    const double range[2] = { std::sqrt(ranges.SquaredNorm.Minimum),
      std::sqrt(ranges.SquaredNorm.Maximum) };
    vtkInformation* information = array->GetInformation();
    information->Set(vtkDataArray::L2_NORM_RANGE(), range, 2);
    information->Set(vtkDataArray::L2_NORM_FINITE_RANGE(), range, 2);
  }
}

template <typename ArrayT>
bool StoreRangesOf(vtkDataArray* array, int threads)
{
  using T = typename ArrayT::ValueType;
  auto* typed = ArrayT::FastDownCast(array);
  if (!typed || typed->GetNumberOfTuples() == 0)
  {
    return false;
  }
  const TupleRanges<T> all =
    FindTupleRanges(typed->GetPointer(0), static_cast<std::size_t>(typed->GetNumberOfTuples()),
      static_cast<std::size_t>(typed->GetNumberOfComponents()), threads);
  if (all.AreFinite)
  {
    Store(array, all);
  }
  return true;
}

void StoreRangesOfArray(vtkDataArray* array, int threads)
{
  if (array)
  {
    static_cast<void>(StoreRangesOf<vtkFloatArray>(array, threads) ||
      StoreRangesOf<vtkDoubleArray>(array, threads) ||
      StoreRangesOf<vtkIdTypeArray>(array, threads));
  }
}

/// Access to the protected bounds of vtkPoints, which it computes even if its array knows its
/// ranges. There are no objects of this class.
class KeptBounds : public vtkPoints
{
public:
  static void Store(vtkPoints* points)
  {
    vtkDataArray* array = points->GetData();
    if (array->HasInformation() && array->GetInformation()->Has(vtkDataArray::PER_COMPONENT()))
    {
      double(vtkPoints::*bounds)[6] = &KeptBounds::Bounds;
      vtkTimeStamp vtkPoints::*time = &KeptBounds::ComputeTime;
      for (int axis = 0; axis < 3; ++axis)
      {
        array->GetRange(points->*bounds + static_cast<std::ptrdiff_t>(2 * axis), axis);
      }
      (points->*time).Modified();
    }
  }
};

} // namespace

void StoreRanges(vtkPolyData* surface, int threads)
{
  if (surface->GetPoints())
  {
    StoreRangesOfArray(surface->GetPoints()->GetData(), threads);
    KeptBounds::Store(surface->GetPoints());
  }
  vtkPointData* arrays = surface->GetPointData();
  for (int n = 0; n < arrays->GetNumberOfArrays(); ++n)
  {
    StoreRangesOfArray(arrays->GetArray(n), threads);
  }
}

void StoreRange(vtkDataArray* array, double minimum, double maximum)
{
  const std::vector<ValueSpan<double>> spans = { ValueSpan<double>{ minimum, maximum } };
  StoreComponents(array, spans);
}

} // namespace isosurface
