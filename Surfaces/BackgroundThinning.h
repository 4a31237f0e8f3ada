// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BackgroundThinning_h
#define isosurface_BackgroundThinning_h

#include "MeasuredTriangles.h"
#include "Surface/Drawing/SurfaceThinning.h"
#include "vtkSmartPointer.h"

#include <future>
#include <optional>

class vtkDataArray;
class vtkPolyData;

namespace isosurface
{

/// How much of a surface a view wants while the camera moves, by its resolution, 0 to 1.
ThinningLimits ChooseThinningLimits(double resolution);

/**
 * Fills `thinned` with the points of a surface that are kept, all their arrays but GlobalIds, and
 * the triangles between them.
 */
void CopyThinned(vtkPolyData* surface, const ThinnedSurface& kept, vtkPolyData* thinned);

/**
 * Thins a surface by a thread of low priority while the surface is drawn, so that the first frame
 * of a drag need not wait for it. Only the points and triangles are read; they must not be changed
 * in place meanwhile, as they must not while they are drawn.
 */
class BackgroundThinning
{
public:
  /// Begins with a surface that `triangles` has measured; no effect if that one is thinned already,
  /// or while another one is.
  void Begin(
    vtkPolyData* surface, const MeasuredTriangles& triangles, const ThinningLimits& limits);
  /// Forgets a surface that was not taken, unless it is being thinned.
  void Forget();
  /// What is kept of a surface, if Begin was called with it and the same limits; waits for it. The
  /// next call has nothing.
  std::optional<ThinnedSurface> Take(vtkPolyData* surface, const ThinningLimits& limits);

private:
  bool IsThinning() const;

  /// What a surface is known by, and held by while it is thinned.
  struct Source
  {
    vtkSmartPointer<vtkDataArray> Points;
    vtkSmartPointer<vtkDataArray> Connectivity;
    vtkMTimeType PointsTime = 0;
    vtkMTimeType ConnectivityTime = 0;
    ThinningLimits Limits;

    Source() = default;
    Source(vtkPolyData* surface, const ThinningLimits& limits);
    bool operator==(const Source& other) const;
  };

  Source Known;
  std::future<ThinnedSurface> Result; ///< the last member: its destructor waits for the thread
};

} // namespace isosurface

#endif
