// SPDX-License-Identifier: BSD-3-Clause
#include "BackgroundThinning.h"

#include "vtkCellArray.h"
#include "vtkDataArray.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include "Ground/Base/ThreadPriority.h"

#include <chrono>
#include <new>
#include <system_error>

namespace isosurface
{

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
