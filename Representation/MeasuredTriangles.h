// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MeasuredTriangles_h
#define isosurface_MeasuredTriangles_h

#include "vtkType.h"

#include "Drawing/TriangleMeasure.h"
#include "Drawing/TriangleSurface.h"

class vtkPolyData;

namespace isosurface
{

/**
 * The triangles of a vtkPolyData and their measure, which is kept until one of the arrays changes.
 * Copies of the surface that share its arrays share the measure.
 */
class MeasuredTriangles
{
public:
  /**
   * Whether the surface has triangles alone, float points, and fewer indices than 32 bits count:
   * then Surface and Measure are its own, until the next call. Measures it unless it did so before,
   * by `threads` threads.
   */
  bool Measure(vtkPolyData* surface, int threads);

  const TriangleSurface& GetSurface() const { return this->Surface; }
  const TriangleMeasure& GetMeasure() const { return this->Found; }

private:
  /// Of which arrays the measure is. Times are never the same for two arrays.
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

/// Stores the bounds that vtkPolyData::GetCellsBounds would count, unless it knows them.
void StoreCellsBounds(vtkPolyData* surface, const TriangleMeasure& measure);

/// The number of threads of a process among `vtkMultiProcessController`'s, taken to be on one node.
int ChooseDrawingThreads();

} // namespace isosurface

#endif
