// SPDX-License-Identifier: BSD-3-Clause
#include "BackgroundThinning.h"

#include "Ground/Base/BackgroundTask.h"
#include "vtkAbstractArray.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkFieldData.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkTypeInt32Array.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <system_error>
#include <vector>

namespace isosurface
{
namespace
{

/// Some tuples of an array, as an array of the same class.
vtkSmartPointer<vtkAbstractArray> CopyTuples(
  vtkAbstractArray* array, const std::vector<std::uint32_t>& tuples)
{
  const auto count = static_cast<vtkIdType>(tuples.size());
  auto copy = vtkSmartPointer<vtkAbstractArray>::Take(array->NewInstance());
  copy->SetName(array->GetName());
  copy->SetNumberOfComponents(array->GetNumberOfComponents());
  copy->CopyComponentNames(array);
  if (array->HasInformation())
  {
    copy->CopyInformation(array->GetInformation(), 1);
  }
  copy->SetNumberOfTuples(count);
  auto* data = vtkDataArray::SafeDownCast(array);
  if (data && data->HasStandardMemoryLayout() && data->GetDataType() != VTK_BIT)
  {
    const std::size_t size = static_cast<std::size_t>(data->GetDataTypeSize()) *
      static_cast<std::size_t>(data->GetNumberOfComponents());
    const auto* from = static_cast<const unsigned char*>(data->GetVoidPointer(0));
    auto* to = static_cast<unsigned char*>(copy->GetVoidPointer(0));
    for (const std::uint32_t tuple : tuples)
    {
      std::memcpy(to, from + tuple * size, size);
      to += size;
    }
    vtkDataArray::SafeDownCast(copy)->SetLookupTable(data->GetLookupTable());
    return copy;
  }
  for (vtkIdType tuple = 0; tuple < count; ++tuple)
  {
    copy->SetTuple(tuple, tuples[static_cast<std::size_t>(tuple)], array);
  }
  return copy;
}

void CopyArrays(vtkDataSetAttributes* arrays, const std::vector<std::uint32_t>& tuples,
  vtkDataSetAttributes* thinned)
{
  for (int index = 0; index < arrays->GetNumberOfArrays(); ++index)
  {
    const int attribute = arrays->IsArrayAnAttribute(index);
    if (attribute == vtkDataSetAttributes::GLOBALIDS)
    {
      continue;
    }
    const int added = thinned->AddArray(CopyTuples(arrays->GetAbstractArray(index), tuples));
    if (attribute >= 0)
    {
      thinned->SetActiveAttribute(added, attribute);
    }
  }
}

void CopyPoints(vtkPolyData* surface, const ThinnedSurface& kept, vtkPolyData* thinned)
{
  vtkNew<vtkPoints> points;
  points->SetData(
    vtkDataArray::SafeDownCast(CopyTuples(surface->GetPoints()->GetData(), kept.Points)));
  thinned->SetPoints(points);
  CopyArrays(surface->GetPointData(), kept.Points, thinned->GetPointData());
}

void CopyTriangles(const ThinnedSurface& kept, vtkPolyData* thinned)
{
  const auto indices = static_cast<vtkIdType>(kept.Triangles.size());
  vtkNew<vtkTypeInt32Array> connectivity;
  connectivity->SetNumberOfValues(indices);
  std::copy(kept.Triangles.begin(), kept.Triangles.end(), connectivity->GetPointer(0));
  vtkNew<vtkTypeInt32Array> offsets;
  offsets->SetNumberOfValues(indices / 3 + 1);
  for (vtkIdType triangle = 0; triangle <= indices / 3; ++triangle)
  {
    offsets->SetValue(triangle, static_cast<std::int32_t>(3 * triangle));
  }
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, connectivity);
  thinned->SetPolys(cells);
}

} // namespace

ThinningLimits ChooseThinningLimits(double resolution)
{
  // A third more cells along a side than ParaView's own clustering has.
  ThinningLimits limits;
  limits.Cells = static_cast<int>(10 + 200 * std::clamp(resolution, 0.0, 1.0));
  return limits;
}

void CopyThinned(vtkPolyData* surface, const ThinnedSurface& kept, vtkPolyData* thinned)
{
  thinned->Initialize();
  CopyPoints(surface, kept, thinned);
  CopyTriangles(kept, thinned);
  CopyArrays(surface->GetCellData(), kept.Numbers, thinned->GetCellData());
  thinned->GetFieldData()->ShallowCopy(surface->GetFieldData());
}

BackgroundThinning::Source::Source(vtkPolyData* surface, const ThinningLimits& limits)
  : Points(surface->GetPoints()->GetData())
  , Connectivity(surface->GetPolys()->GetConnectivityArray())
  , PointsTime(Points->GetMTime())
  , ConnectivityTime(Connectivity->GetMTime())
  , Limits(limits)
{
}

bool BackgroundThinning::Source::operator==(const Source& other) const
{
  return this->Points == other.Points && this->Connectivity == other.Connectivity &&
    this->PointsTime == other.PointsTime && this->ConnectivityTime == other.ConnectivityTime &&
    this->Limits.Cells == other.Limits.Cells && this->Limits.Points == other.Limits.Points;
}

bool BackgroundThinning::IsThinning() const
{
  return this->Result.valid() &&
    this->Result.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

void BackgroundThinning::Forget()
{
  if (!this->IsThinning())
  {
    this->Result = {};
    this->Known = {};
  }
}

void BackgroundThinning::Begin(
  vtkPolyData* surface, const MeasuredTriangles& triangles, const ThinningLimits& limits)
{
  const Source source(surface, limits);
  if (this->IsThinning() || (this->Result.valid() && source == this->Known))
  {
    return;
  }
  try
  {
    this->Result = std::async(std::launch::async,
      [view = triangles.GetSurface(), measure = triangles.GetMeasure(), limits]
      {
        LowerThreadPriority();
        return ThinSurface(view, measure, limits, 1);
      });
    this->Known = source;
  }
  catch (const std::system_error&)
  {
    // There is no thread: it is thinned when it is needed.
    this->Forget();
  }
}

std::optional<ThinnedSurface> BackgroundThinning::Take(
  vtkPolyData* surface, const ThinningLimits& limits)
{
  if (!this->Result.valid() || !(Source(surface, limits) == this->Known))
  {
    return std::nullopt;
  }
  this->Known = {};
  try
  {
    return this->Result.get();
  }
  catch (const std::bad_alloc&)
  {
    return std::nullopt;
  }
}

} // namespace isosurface
