// SPDX-License-Identifier: BSD-3-Clause
#include "ThinnedPolyData.h"

#include "vtkCellArray.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkIdList.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkTypeInt32Array.h"

#include "Drawing/SurfaceThinning.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace isosurface
{
namespace
{

/// A third more cells along a side than ParaView's own clustering has.
ThinningLimits ChooseLimits(double resolution)
{
  ThinningLimits limits;
  limits.Cells = static_cast<int>(10 + 200 * std::clamp(resolution, 0.0, 1.0));
  return limits;
}

void CopyPoints(vtkPolyData* surface, const ThinnedSurface& kept, vtkPolyData* thinned)
{
  const auto count = static_cast<vtkIdType>(kept.Points.size());
  vtkNew<vtkIdList> from;
  vtkNew<vtkIdList> to;
  from->SetNumberOfIds(count);
  to->SetNumberOfIds(count);
  std::copy(kept.Points.begin(), kept.Points.end(), from->GetPointer(0));
  std::iota(to->GetPointer(0), to->GetPointer(0) + count, vtkIdType{ 0 });

  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(count);
  points->GetData()->InsertTuples(to, from, surface->GetPoints()->GetData());
  thinned->SetPoints(points);
  vtkPointData* arrays = thinned->GetPointData();
  arrays->CopyAllOn();
  arrays->CopyGlobalIdsOff();
  arrays->CopyAllocate(surface->GetPointData(), count);
  arrays->CopyData(surface->GetPointData(), from, to);
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

void ThinPolyData(vtkPolyData* surface, const MeasuredTriangles& triangles, double resolution,
  int threads, vtkPolyData* thinned)
{
  const ThinnedSurface kept =
    ThinSurface(triangles.GetSurface(), triangles.GetMeasure(), ChooseLimits(resolution), threads);
  thinned->Initialize();
  CopyPoints(surface, kept, thinned);
  CopyTriangles(kept, thinned);
  thinned->GetFieldData()->ShallowCopy(surface->GetFieldData());
}

} // namespace isosurface
