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

#include "Base/ParallelFor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

namespace isosurface
{
namespace
{

/// So many tuples at a time have lanes of their own, which a compiler takes in one register.
constexpr std::size_t TuplesAtOnce = 16;
constexpr std::size_t TuplesOfTask = std::size_t{ 1 } << 16;

template <typename T>
struct Span
{
  T Least = std::numeric_limits<T>::max();
  T Most = std::numeric_limits<T>::lowest();

  void Add(T value)
  {
    this->Least = value < this->Least ? value : this->Least;
    this->Most = value > this->Most ? value : this->Most;
  }
  void Add(const Span& other)
  {
    this->Least = std::min(this->Least, other.Least);
    this->Most = std::max(this->Most, other.Most);
  }
};

/// Of some tuples.
template <typename T>
struct TupleRanges
{
  std::vector<Span<T>> Components;
  Span<double> SquaredNorm;
  bool AreFinite = true;
};

template <typename T>
TupleRanges<T> FindRanges(const T* values, std::size_t tuples, std::size_t components)
{
  TupleRanges<T> ranges;
  const std::size_t lanes = TuplesAtOnce * components;
  std::vector<Span<T>> spans(lanes);
  const std::size_t count = tuples * components;
  std::size_t at = 0;
  for (; at + lanes <= count; at += lanes)
  {
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
      spans[lane].Add(values[at + lane]);
    }
  }
  for (std::size_t lane = 0; at < count; ++at, ++lane)
  {
    spans[lane].Add(values[at]);
  }
  ranges.Components.resize(components);
  for (std::size_t lane = 0; lane < lanes; ++lane)
  {
    ranges.Components[lane % components].Add(spans[lane]);
  }
  if constexpr (std::is_floating_point_v<T>)
  {
    // A sum of zeros, unless a value is not finite.
    T zeros[TuplesAtOnce] = {};
    for (at = 0; at < count; ++at)
    {
      zeros[at % TuplesAtOnce] += values[at] * 0;
    }
    ranges.AreFinite = std::all_of(zeros, zeros + TuplesAtOnce, [](T zero) { return zero == 0; });
  }
  for (std::size_t tuple = 0; components > 1 && tuple < tuples; ++tuple)
  {
    double sum = 0;
    for (std::size_t component = 0; component < components; ++component)
    {
      const auto value = static_cast<double>(values[tuple * components + component]);
      sum += value * value;
    }
    ranges.SquaredNorm.Add(sum);
  }
  return ranges;
}

template <typename T>
void Store(vtkDataArray* array, const TupleRanges<T>& ranges)
{
  vtkInformation* information = array->GetInformation();
  for (vtkInformationInformationVectorKey* key :
    { vtkDataArray::PER_COMPONENT(), vtkDataArray::PER_FINITE_COMPONENT() })
  {
    vtkNew<vtkInformationVector> components;
    for (const Span<T>& span : ranges.Components)
    {
      const double range[2] = { static_cast<double>(span.Least), static_cast<double>(span.Most) };
      vtkNew<vtkInformation> component;
      component->Set(vtkDataArray::COMPONENT_RANGE(), range, 2);
      components->Append(component);
    }
    information->Set(key, components);
  }
  if (ranges.Components.size() > 1)
  {
    const double range[2] = { std::sqrt(ranges.SquaredNorm.Least),
      std::sqrt(ranges.SquaredNorm.Most) };
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
  const T* values = typed->GetPointer(0);
  const auto tuples = static_cast<std::size_t>(typed->GetNumberOfTuples());
  const auto components = static_cast<std::size_t>(typed->GetNumberOfComponents());
  std::vector<TupleRanges<T>> parts((tuples - 1) / TuplesOfTask + 1);
  ParallelFor(parts.size(), threads,
    [&](std::size_t part, int)
    {
      const std::size_t first = part * TuplesOfTask;
      parts[part] =
        FindRanges(values + first * components, std::min(TuplesOfTask, tuples - first), components);
    });
  TupleRanges<T>& all = parts.front();
  for (const TupleRanges<T>& part : parts)
  {
    for (std::size_t component = 0; component < components; ++component)
    {
      all.Components[component].Add(part.Components[component]);
    }
    all.SquaredNorm.Add(part.SquaredNorm);
    all.AreFinite = all.AreFinite && part.AreFinite;
  }
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

/// Reaches the bounds that vtkPoints keeps, which it does not take from its array; never made.
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

} // namespace isosurface
