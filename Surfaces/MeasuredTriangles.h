// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MeasuredTriangles_h
#define isosurface_MeasuredTriangles_h

#include "vtkType.h"

#include "Surface/Drawing/TriangleMeasure.h"
#include "Surface/Drawing/TriangleSurface.h"

class vtkDataObject;
class vtkPolyData;

namespace isosurface
{

/// The surface of data that has no other block, as views and mappers get it; null for other data.
vtkPolyData* GetSurfaceAlone(vtkDataObject* data);

/**
 * The triangles of a vtkPolyData and their measure, which is kept until one of the arrays changes.
 * Copies of the surface that share its arrays share the measure.
 */
class MeasuredTriangles
{
public:
  /**
   * Whether the surface has triangles alone, float points, and numbers of points and indices that
   * fit 32 bits: then GetSurface() and GetMeasure() are its, until the next call. Measures it, by
   * `threads` threads, unless it did so before. The surface must outlive the use of GetSurface().
   */
  bool Measure(vtkPolyData* surface, int threads);

  const TriangleSurface& GetSurface() const { return this->Surface; }
  const TriangleMeasure& GetMeasure() const { return this->Found; }

private:
  /// Tells the arrays that were measured by their modification times, which VTK gives out once.
  struct Key
  {
    vtkMTimeType Points = 0;
    vtkMTimeType Offsets = 0;
    vtkMTimeType Connectivity = 0;

    bool operator==(const Key& other) const
    {
      return this->Points == other.Points && this->Offsets == other.Offsets &&
        this->Connectivity == other.Connectivity;
    }
  };

  Key Measured;
  bool IsCovered = false;
  TriangleSurface Surface;
  TriangleMeasure Found;
};

/// Stores the bounds that vtkPolyData::GetCellsBounds would compute, unless it knows them.
void StoreCellsBounds(vtkPolyData* surface, const TriangleMeasure& measure);

/// This rank's share of the node's cores, as if all ranks of the global controller were on one
/// node.
int ChooseDrawingThreads();

} // namespace isosurface

#endif
